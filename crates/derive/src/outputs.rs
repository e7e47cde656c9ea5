//! `#[derive(Outputs)]`: the outputs of a node.

use crate::choice::variants;
use crate::docs::help;
use crate::items::snake;
use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::ParseStream;
use syn::{DeriveInput, Error, Expr, Ident, LitStr, Token};

/// Arguments of `#[output(…)]`.
struct OutputArguments {
    kind: Expr,
    name: Option<String>,
    stored: Option<Expr>,
}

fn parse(input: ParseStream<'_>) -> Result<OutputArguments, Error> {
    let mut arguments = OutputArguments { kind: input.parse()?, name: None, stored: None };
    while !input.is_empty() {
        input.parse::<Token![,]>()?;
        let key: Ident = input.parse()?;
        input.parse::<Token![=]>()?;
        match key.to_string().as_str() {
            "name" => arguments.name = Some(input.parse::<LitStr>()?.value()),
            "stored" => arguments.stored = Some(input.parse()?),
            _ => return Err(Error::new_spanned(key, "expected name or stored")),
        }
    }
    Ok(arguments)
}

/// Makes the expression for one output.
pub(crate) fn output(name: &str, kind: &Expr, others: &[Expr], help: &str, stored: Option<&Expr>) -> TokenStream {
    let stored = stored.map_or(quote!(&[]), |stored| quote!(&#stored));
    quote! {
        ::trochoid_graph::Output { name: #name, kind: #kind, others: &[#(#others),*], help: #help, stored: #stored }
    }
}

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream, Error> {
    let mut outputs = Vec::new();
    let mut names = Vec::new();
    for variant in variants(input)? {
        let attribute = variant.attrs.iter().find(|attribute| attribute.path().is_ident("output"));
        let attribute =
            attribute.ok_or_else(|| Error::new_spanned(variant, "expected its kind: #[output(Kind::MASK)]"))?;
        let arguments = attribute.parse_args_with(parse)?;
        let name = arguments.name.unwrap_or_else(|| snake(&variant.ident));
        outputs.push(output(&name, &arguments.kind, &[], &help(&variant.attrs, variant)?, arguments.stored.as_ref()));
        names.push(&variant.ident);
    }
    let (name, count) = (&input.ident, names.len());
    Ok(quote! {
        impl #name {
            /// Every output, in order.
            #[allow(dead_code)]
            pub(crate) const ALL: [Self; #count] = [#(Self::#names),*];
        }

        impl ::trochoid_graph::OutputSet for #name {
            const OUTPUTS: &'static [::trochoid_graph::Output] = &[#(#outputs),*];
        }

        impl ::std::convert::From<#name> for usize {
            fn from(output: #name) -> usize {
                output as usize
            }
        }
    })
}
