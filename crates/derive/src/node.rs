//! `#[derive(Node)]`: the declaration of a node.

use crate::docs::Sections;
use crate::items::fields;
use crate::outputs::output;
use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::token::Paren;
use syn::{DeriveInput, Error, Expr, Ident, LitInt, LitStr, Path, Token, parenthesized, parse_quote};

/// Arguments of `#[node(…)]`.
#[derive(Default)]
struct Said {
    name: Option<String>,
    end: Option<Ident>,
    revision: Option<LitInt>,
    outputs: Option<TokenStream>,
    role: Option<Ident>,
    offers: Vec<Ident>,
}

/// Parses a single output, `mask: Kind::MASK = "Help."`, optionally followed by the names of its channels in files.
fn single(input: ParseStream<'_>) -> Result<TokenStream, Error> {
    let name: Ident = input.parse()?;
    input.parse::<Token![:]>()?;
    let path: Path = input.parse()?;
    let kind = if input.peek(Paren) {
        let content;
        parenthesized!(content in input);
        let arguments: TokenStream = content.parse()?;
        parse_quote! { #path(#arguments) }
    } else {
        parse_quote! { #path }
    };
    input.parse::<Token![=]>()?;
    let help = input.parse::<LitStr>()?.value();
    let mut stored = None;
    if !input.is_empty() {
        input.parse::<Token![,]>()?;
        stored = Some(input.parse::<Expr>()?);
    }
    let output = output(&name.to_string(), &kind, &help, stored.as_ref());
    Ok(quote! { &[#output] })
}

fn parse(input: ParseStream<'_>) -> Result<Said, Error> {
    let mut said = Said::default();
    while !input.is_empty() {
        let key: Ident = input.parse()?;
        match key.to_string().as_str() {
            "output" => {
                let content;
                parenthesized!(content in input);
                said.outputs = Some(single(&content)?);
            }
            "offers" => {
                let content;
                parenthesized!(content in input);
                said.offers = content.parse_terminated(Ident::parse, Token![,])?.into_iter().collect();
            }
            other => {
                input.parse::<Token![=]>()?;
                match other {
                    "name" => said.name = Some(input.parse::<LitStr>()?.value()),
                    "end" => said.end = Some(input.parse()?),
                    "revision" => said.revision = Some(input.parse()?),
                    "role" => said.role = Some(input.parse()?),
                    "outputs" => {
                        let path: Path = input.parse()?;
                        said.outputs = Some(quote! { <#path as ::trochoid_graph::OutputSet>::OUTPUTS });
                    }
                    _ => {
                        let known = "expected name, end, revision, outputs, output(…), role or offers(…)";
                        return Err(Error::new_spanned(key, known));
                    }
                }
            }
        }
        if !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
    }
    Ok(said)
}

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream, Error> {
    let attribute = input.attrs.iter().find(|attribute| attribute.path().is_ident("node"));
    let example = "#[node(end = Back, revision = 1, output(mask: Kind::MASK = \"Help.\"))]";
    let attribute = attribute.ok_or_else(|| Error::new_spanned(input, format!("expected {example}")))?;
    let said = attribute.parse_args_with(parse)?;
    let lacks = |what: &str| Error::new_spanned(attribute, format!("no {what}: expected {example}"));
    let end = said.end.ok_or_else(|| lacks("end"))?;
    let revision = said.revision.ok_or_else(|| lacks("revision"))?;
    let outputs = said.outputs.ok_or_else(|| lacks("outputs"))?;
    let Sections { summary, formula, edge_cases, source } = Sections::of(&input.attrs, &input.ident)?;
    let ident = &input.ident;
    let name = said.name.unwrap_or_else(|| ident.to_string());
    let role = match said.role {
        Some(role) => quote! { ::std::option::Option::Some(::trochoid_graph::Role::#role) },
        None => quote! { ::std::option::Option::None },
    };
    let offers = said.offers;
    let items = fields(input)?;
    Ok(quote! {
        #items

        impl ::trochoid_graph::Declare for #ident {
            const DECLARATION: &'static ::trochoid_graph::Declaration = &::trochoid_graph::Declaration {
                name: #name,
                end: ::trochoid_graph::End::#end,
                summary: #summary,
                formula: #formula,
                edge_cases: #edge_cases,
                source: #source,
                items: <#ident as ::trochoid_graph::Items>::ITEMS,
                outputs: #outputs,
                role: #role,
                offers: &[#(::trochoid_graph::Offer::#offers),*],
                revision: #revision,
            };
        }
    })
}
