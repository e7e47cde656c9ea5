//! `#[derive(Choice)]`: the words of a knob.

use crate::items::snake;
use proc_macro2::TokenStream;
use quote::quote;
use syn::{Data, DeriveInput, Error, Fields, Ident, LitStr, Variant};

/// Returns the variants of an enum, none of which may have data.
pub(crate) fn variants(input: &DeriveInput) -> Result<Vec<&Variant>, Error> {
    let Data::Enum(data) = &input.data else { return Err(Error::new_spanned(input, "expected an enum")) };
    for variant in &data.variants {
        if !matches!(variant.fields, Fields::Unit) {
            return Err(Error::new_spanned(variant, "expected a variant without data"));
        }
    }
    if data.variants.is_empty() {
        return Err(Error::new_spanned(input, "expected at least one variant"));
    }
    Ok(data.variants.iter().collect())
}

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream, Error> {
    let variants = variants(input)?;
    let mut words = Vec::new();
    for variant in &variants {
        let own = variant.attrs.iter().find(|attribute| attribute.path().is_ident("word"));
        words.push(match own {
            Some(attribute) => attribute.parse_args::<LitStr>()?.value(),
            None => snake(&variant.ident),
        });
    }
    let name = &input.ident;
    let names: Vec<&Ident> = variants.iter().map(|variant| &variant.ident).collect();
    let first = names[0];
    Ok(quote! {
        impl ::trochoid_graph::Choice for #name {
            const WORDS: &'static [&'static str] = &[#(#words),*];

            fn word(&self) -> &'static str {
                match self { #(Self::#names => #words),* }
            }
        }

        impl ::trochoid_graph::ReadSetting for #name {
            fn read(setting: &::trochoid_graph::Setting<::std::vec::Vec<f64>>) -> Self {
                match setting {
                    #(::trochoid_graph::Setting::Text(word) if word == #words => Self::#names,)*
                    // Validation refuses other words.
                    _ => Self::#first,
                }
            }
        }
    })
}
