//! `#[derive(Node)]`: the declaration of a node.

use crate::docs::Sections;
use crate::items::fields;
use crate::outputs::output;
use proc_macro2::TokenStream;
use quote::quote;
use syn::parse::{Parse, ParseStream};
use syn::token::Paren;
use syn::{DeriveInput, Error, Expr, Ident, LitInt, LitStr, Path, Token, bracketed, parenthesized, parse_quote};

/// Arguments of `#[node(…)]`.
#[derive(Default)]
struct NodeArguments {
    name: Option<String>,
    end: Option<Ident>,
    revision: Option<LitInt>,
    outputs: Option<TokenStream>,
    example: Option<String>,
    role: Option<Ident>,
    offers: Vec<Ident>,
    reads: Option<TokenStream>,
    body: Option<Ident>,
}

/// Parses a single output, `mask: Kind::MASK = "Help."`, optionally followed by the names of its channels in files. Kinds
/// that knobs can decide instead follow the kind: `image: Kind::Color or [Kind::MASK] = "Help."`.
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
    let mut others = Vec::new();
    if input.peek(Ident) {
        let word: Ident = input.parse()?;
        if word != "or" {
            return Err(Error::new_spanned(word, "expected = or the word or"));
        }
        let content;
        bracketed!(content in input);
        others = content.parse_terminated(Expr::parse, Token![,])?.into_iter().collect();
    }
    input.parse::<Token![=]>()?;
    let help = input.parse::<LitStr>()?.value();
    let mut stored = None;
    if !input.is_empty() {
        input.parse::<Token![,]>()?;
        stored = Some(input.parse::<Expr>()?);
    }
    let output = output(&name.to_string(), &kind, &others, &help, stored.as_ref());
    Ok(quote! { &[#output] })
}

fn parse(input: ParseStream<'_>) -> Result<NodeArguments, Error> {
    let mut arguments = NodeArguments::default();
    while !input.is_empty() {
        let key: Ident = input.parse()?;
        match key.to_string().as_str() {
            "output" => {
                let content;
                parenthesized!(content in input);
                arguments.outputs = Some(single(&content)?);
            }
            "stage" => arguments.body = Some(Ident::new("Stage", key.span())),
            "pointwise" => arguments.body = Some(Ident::new("Pointwise", key.span())),
            "offers" => {
                let content;
                parenthesized!(content in input);
                arguments.offers = content.parse_terminated(Ident::parse, Token![,])?.into_iter().collect();
            }
            "reads" => {
                let content;
                parenthesized!(content in input);
                let what: LitStr = content.parse()?;
                content.parse::<Token![:]>()?;
                let endings = content.parse_terminated(<LitStr as Parse>::parse, Token![,])?.into_iter();
                arguments.reads = Some(quote! { ::trochoid_graph::Files { what: #what, endings: &[#(#endings),*] } });
            }
            other => {
                input.parse::<Token![=]>()?;
                match other {
                    "name" => arguments.name = Some(input.parse::<LitStr>()?.value()),
                    "end" => arguments.end = Some(input.parse()?),
                    "revision" => arguments.revision = Some(input.parse()?),
                    "role" => arguments.role = Some(input.parse()?),
                    "example" => arguments.example = Some(input.parse::<LitStr>()?.value()),
                    "outputs" => {
                        let path: Path = input.parse()?;
                        arguments.outputs = Some(quote! { <#path as ::trochoid_graph::OutputSet>::OUTPUTS });
                    }
                    _ => {
                        let known = "expected stage, pointwise, name, end, revision, outputs, output(…), role, \
                                     example, offers(…) or reads(…)";
                        return Err(Error::new_spanned(key, known));
                    }
                }
            }
        }
        if !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
    }
    Ok(arguments)
}

/// `#[also_called("Crop", "Resize" => "its \"fit\"")]`: words, and how the node does their job.
fn aliases(input: ParseStream<'_>) -> Result<Vec<TokenStream>, Error> {
    let (mut words, mut hint): (Vec<LitStr>, _) = (Vec::new(), String::new());
    while !input.is_empty() {
        words.push(input.parse()?);
        if input.peek(Token![=>]) {
            input.parse::<Token![=>]>()?;
            hint = input.parse::<LitStr>()?.value();
            break;
        }
        if !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
    }
    Ok(words.iter().map(|word| quote! { ::trochoid_graph::Alias { word: #word, hint: #hint } }).collect())
}

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream, Error> {
    let attribute = input.attrs.iter().find(|attribute| attribute.path().is_ident("node"));
    let example = "#[node(end = Back, revision = 1, output(mask: Kind::MASK = \"Help.\"))]";
    let attribute = attribute.ok_or_else(|| Error::new_spanned(input, format!("expected {example}")))?;
    let arguments = attribute.parse_args_with(parse)?;
    let missing = |what: &str| Error::new_spanned(attribute, format!("no {what}: expected {example}"));
    let end = arguments.end.ok_or_else(|| missing("end"))?;
    let revision = arguments.revision.ok_or_else(|| missing("revision"))?;
    let outputs = arguments.outputs.ok_or_else(|| missing("outputs"))?;
    let Sections { summary, formula, edge_cases, source } = Sections::of(&input.attrs, &input.ident)?;
    let ident = &input.ident;
    let name = arguments.name.unwrap_or_else(|| ident.to_string());
    let role = match arguments.role {
        Some(role) => quote! { ::std::option::Option::Some(::trochoid_graph::Role::#role) },
        None => quote! { ::std::option::Option::None },
    };
    let reads = match arguments.reads {
        Some(reads) => quote! { ::std::option::Option::Some(#reads) },
        None => quote! { ::std::option::Option::None },
    };
    let offers = arguments.offers;
    let also = input.attrs.iter().filter(|attribute| attribute.path().is_ident("also_called"));
    let also: Vec<Vec<TokenStream>> =
        also.map(|attribute| attribute.parse_args_with(aliases)).collect::<Result<_, _>>()?;
    let also = also.concat();
    let items = fields(input)?;
    let computes = arguments.body.map(|body| {
        quote! {
            impl ::trochoid_graph::Computes for #ident {
                fn body(&self) -> ::trochoid_graph::Body<'_> {
                    ::trochoid_graph::Body::#body(self)
                }
            }
        }
    });
    let example = arguments.example.unwrap_or_default();
    Ok(quote! {
        #items
        #computes

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
                reads: #reads,
                aliases: &[#(#also),*],
                example: #example,
                revision: #revision,
            };
        }
    })
}
