//! `#[derive(Items)]`: a struct of ports and knobs.

use crate::field::{FieldCode, field_code};
use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::ext::IdentExt as _;
use syn::{Data, DeriveInput, Error, Fields, Ident};

/// Converts a Rust name to snake case, as used in documents.
pub(crate) fn snake(name: &Ident) -> String {
    let mut text = String::new();
    for (index, letter) in name.unraw().to_string().chars().enumerate() {
        if letter.is_uppercase() && index > 0 {
            text.push('_');
        }
        text.extend(letter.to_lowercase());
    }
    text
}

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream, Error> {
    fields(input)
}

/// Makes the code for a struct: its items, the function that reads them, and their names as constants.
pub(crate) fn fields(input: &DeriveInput) -> Result<TokenStream, Error> {
    let Data::Struct(data) = &input.data else { return Err(Error::new_spanned(input, "expected a struct")) };
    let named = match &data.fields {
        Fields::Named(fields) => fields.named.iter().collect(),
        Fields::Unit => Vec::new(),
        Fields::Unnamed(_) => return Err(Error::new_spanned(input, "expected a struct with named fields")),
    };
    let (mut parts, mut reads, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for field in named {
        let Some(ident) = &field.ident else { continue };
        let FieldCode { items, read } = field_code(field)?;
        parts.push(items);
        reads.push(quote! { #ident: #read });
        let text = ident.unraw().to_string();
        let constant = format_ident!("{}", text.to_uppercase());
        names.push(quote! {
            #[allow(dead_code)]
            pub(crate) const #constant: ::trochoid_graph::ItemName = ::trochoid_graph::ItemName::declared(#text);
        });
    }
    let ident = &input.ident;
    let constructor = if reads.is_empty() { quote!(Self {}) } else { quote!(Self { #(#reads),* }) };
    Ok(quote! {
        impl #ident {
            #(#names)*
        }

        impl ::trochoid_graph::Items for #ident {
            const ITEMS: &'static [::trochoid_graph::Item] = {
                const PARTS: &[&[::trochoid_graph::Item]] = &[#(#parts),*];
                const COUNT: usize = ::trochoid_graph::count_items(PARTS);
                &::trochoid_graph::join_items::<COUNT>(PARTS)
            };

            #[allow(unused_variables)]
            fn read(reader: &mut ::trochoid_graph::Reader<'_>) -> Self {
                #constructor
            }
        }
    })
}
