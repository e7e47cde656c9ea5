//! Fields of a struct: each is a port, a knob, a list, or a group of them.

use crate::docs::help;
use proc_macro2::TokenStream;
use quote::quote;
use syn::ext::IdentExt as _;
use syn::parse::{Parse, ParseStream};
use syn::{Attribute, Error, Expr, ExprRange, Field, GenericArgument, Ident, LitStr, PathArguments, Token, Type};

/// Code for one field: its declaration, and the expression that reads it.
pub(crate) struct FieldCode {
    /// Expression for a slice of items.
    pub(crate) items: TokenStream,
    pub(crate) read: TokenStream,
}

/// Returns the last name of a type, and the first type in its angle brackets.
fn type_name(ty: &Type) -> Option<(String, Option<&Type>)> {
    let Type::Path(path) = ty else { return None };
    let last = path.path.segments.last()?;
    let argument = match &last.arguments {
        PathArguments::AngleBracketed(arguments) => arguments.args.first().and_then(|argument| match argument {
            GenericArgument::Type(ty) => Some(ty),
            _ => None,
        }),
        _ => None,
    };
    Some((last.ident.to_string(), argument))
}

fn attribute<'f>(field: &'f Field, name: &str) -> Option<&'f Attribute> {
    field.attrs.iter().find(|attribute| attribute.path().is_ident(name))
}

/// Returns both ends of `a..=b`.
fn ends(range: &ExprRange) -> Result<[&Expr; 2], Error> {
    match (&range.start, &range.end, &range.limits) {
        (Some(start), Some(end), syn::RangeLimits::Closed(_)) => Ok([start, end]),
        _ => Err(Error::new_spanned(range, "expected a range with both ends: a..=b")),
    }
}

pub(crate) fn field_code(field: &Field) -> Result<FieldCode, Error> {
    let ident = field.ident.as_ref().ok_or_else(|| Error::new_spanned(field, "expected a name"))?;
    let (name, ty) = (ident.unraw().to_string(), &field.ty);
    if attribute(field, "items").is_some() {
        return Ok(FieldCode {
            items: quote! { <#ty as ::trochoid_graph::Items>::ITEMS },
            read: quote! { <#ty as ::trochoid_graph::Items>::read(reader) },
        });
    }
    let help = help(&field.attrs, field)?;
    if let Some(list) = attribute(field, "list") {
        return records(list, &name, ty, &help);
    }
    match type_name(ty) {
        Some((arity, _)) if ["One", "Optional", "Many"].contains(&arity.as_str()) => port(field, &arity, &name, &help),
        _ => knob(field, &name, &help),
    }
}

/// Makes the code for a list of records: `#[list(1..=8)] layers: Vec<Layer>`.
fn records(list: &Attribute, name: &str, ty: &Type, help: &str) -> Result<FieldCode, Error> {
    let range: ExprRange = list.parse_args()?;
    let [min, max] = ends(&range)?;
    let Some((_, Some(record))) = type_name(ty) else { return Err(Error::new_spanned(ty, "expected Vec<Record>")) };
    Ok(FieldCode {
        items: quote! {
            &[::trochoid_graph::Item::List(::trochoid_graph::List {
                name: #name,
                help: #help,
                items: <#record as ::trochoid_graph::Items>::ITEMS,
                min: #min,
                max: #max,
            })]
        },
        read: quote! { reader.list() },
    })
}

/// Arguments of `#[port(…)]`.
#[derive(Default)]
struct PortArguments {
    many: Option<ExprRange>,
    wants: Vec<Ident>,
}

fn parse_port(input: ParseStream<'_>) -> Result<PortArguments, Error> {
    let mut arguments = PortArguments::default();
    while !input.is_empty() {
        if input.peek(Ident) {
            let key: Ident = input.parse()?;
            if key != "wants" {
                return Err(Error::new_spanned(key, "expected a range, or wants(…)"));
            }
            let content;
            syn::parenthesized!(content in input);
            arguments.wants = content.parse_terminated(Ident::parse, Token![,])?.into_iter().collect();
        } else {
            arguments.many = Some(input.parse()?);
        }
        if !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
    }
    Ok(arguments)
}

fn port(field: &Field, arity: &str, name: &str, help: &str) -> Result<FieldCode, Error> {
    let arguments =
        attribute(field, "port").map(|port| port.parse_args_with(parse_port)).transpose()?.unwrap_or_default();
    let arity = match (arity, &arguments.many) {
        ("One", None) => quote! { ::trochoid_graph::Arity::One },
        ("Optional", None) => quote! { ::trochoid_graph::Arity::Optional },
        ("Many", Some(range)) => {
            let [min, max] = ends(range)?;
            quote! { ::trochoid_graph::Arity::Many { min: #min, max: #max } }
        }
        ("Many", None) => return Err(Error::new_spanned(field, "expected a number of connections: #[port(1..=64)]")),
        _ => return Err(Error::new_spanned(field, "only Many<…> takes a range")),
    };
    let (ty, wants) = (&field.ty, arguments.wants);
    Ok(FieldCode {
        items: quote! {
            &[::trochoid_graph::Item::Port(::trochoid_graph::Port {
                name: #name,
                help: #help,
                accepts: <#ty as ::trochoid_graph::Connected>::ACCEPTS,
                arity: #arity,
                wants: &[#(::trochoid_graph::Offer::#wants),*],
            })]
        },
        read: quote! { reader.port() },
    })
}

/// Arguments of `#[knob(…)]`.
#[derive(Default)]
struct KnobArguments {
    default: Option<Expr>,
    range: Option<ExprRange>,
    len: Option<ExprRange>,
    unit: Option<LitStr>,
    places: Option<Ident>,
    flags: Vec<Ident>,
}

impl KnobArguments {
    fn is(&self, flag: &str) -> bool {
        self.flags.iter().any(|known| known == flag)
    }
}

fn parse_knob(input: ParseStream<'_>) -> Result<KnobArguments, Error> {
    const FLAGS: [&str; 8] =
        ["required", "hold_keys", "accuracy", "affects_cost", "in_pixels", "picture_height", "path", "color"];
    let mut arguments = KnobArguments::default();
    while !input.is_empty() {
        let key: Ident = input.parse()?;
        if FLAGS.contains(&key.to_string().as_str()) {
            arguments.flags.push(key);
        } else {
            input.parse::<Token![=]>()?;
            match key.to_string().as_str() {
                "default" => arguments.default = Some(input.parse()?),
                "range" => arguments.range = Some(input.parse()?),
                "len" => arguments.len = Some(input.parse()?),
                "unit" => arguments.unit = Some(input.parse()?),
                "places" => arguments.places = Some(input.parse()?),
                _ => {
                    let known = format!("expected default, range, len, unit, places, or one of {}", FLAGS.join(", "));
                    return Err(Error::new_spanned(key, known));
                }
            }
        }
        if !input.is_empty() {
            input.parse::<Token![,]>()?;
        }
    }
    Ok(arguments)
}

/// Reads the arguments of `#[knob(…)]`; `#[knob]` has none.
fn knob_arguments(field: &Field) -> Result<KnobArguments, Error> {
    match attribute(field, "knob") {
        Some(knob) if matches!(knob.meta, syn::Meta::List(_)) => knob.parse_args_with(parse_knob),
        _ => Ok(KnobArguments::default()),
    }
}

/// Returns the values that a knob of a type takes, its default, and whether it may be keyed.
fn knob_type(
    field: &Field,
    ty: &Type,
    arguments: &KnobArguments,
) -> Result<(TokenStream, Option<TokenStream>, bool), Error> {
    let range = |of: &Option<ExprRange>, example: &str| match of {
        Some(range) => ends(range).map(|ends| ends.map(|end| quote!(#end))),
        None => Err(Error::new_spanned(field, format!("expected {example}"))),
    };
    let default = arguments.default.as_ref();
    if let Type::Array(array) = ty {
        let len = &array.len;
        return Ok(match arguments.is("color") {
            true => (quote! { Color }, None, true),
            false => {
                let default = default.map(|default| quote! { Vector(&{ const VALUES: #ty = #default; VALUES }) });
                (quote! { Vector(#len) }, default, true)
            }
        });
    }
    let (name, argument) = type_name(ty).ok_or_else(|| Error::new_spanned(ty, "expected the type of a knob"))?;
    let inner = argument.and_then(type_name).map(|(name, _)| name);
    Ok(match (name.as_str(), inner.as_deref()) {
        ("f64", _) => {
            let [min, max] = range(&arguments.range, "a range: #[knob(default = 1.0, range = 0.0..=9.0)]")?;
            (quote! { Number { min: #min, max: #max } }, default.map(|default| quote! { Number(#default) }), true)
        }
        ("i64", _) => {
            let [min, max] = range(&arguments.range, "a range: #[knob(default = 1, range = 0..=9)]")?;
            let default = default.map(|default| quote! { Number({ const VALUE: i64 = #default; VALUE as f64 }) });
            (quote! { Integer { min: #min, max: #max } }, default, true)
        }
        ("bool", _) => (quote! { Bool }, default.map(|default| quote! { Bool(#default) }), false),
        ("String", _) if arguments.is("path") => (quote! { Path }, None, false),
        ("String", _) => (quote! { Text }, default.map(|default| quote! { Text(#default) }), false),
        ("Vec", Some("f64")) => {
            let [min, max] = range(&arguments.len, "how many: #[knob(len = 1..=64)]")?;
            (quote! { Numbers { min: #min, max: #max } }, None, false)
        }
        ("Vec", Some("String")) => {
            let [_, max] = range(&arguments.len, "how many: #[knob(len = 0..=64)]")?;
            (quote! { Texts { max: #max } }, Some(quote! { Unset }), false)
        }
        ("Vec", _) => return Err(Error::new_spanned(field, "a list of records takes #[list(1..=8)]")),
        _ => {
            let words = quote! { <#ty as ::trochoid_graph::Choice>::WORDS };
            let default = default.map_or(quote! { Text(#words[0]) }, |word| quote! { Text(#word) });
            (quote! { Choice(#words) }, Some(default), false)
        }
    })
}

fn knob(field: &Field, name: &str, help: &str) -> Result<FieldCode, Error> {
    let arguments = knob_arguments(field)?;
    let (ty, optional) = match type_name(&field.ty) {
        Some((option, Some(inner))) if option == "Option" => (inner, true),
        _ => (&field.ty, false),
    };
    let (knob_type, default, animated) = knob_type(field, ty, &arguments)?;
    let default = match default {
        _ if arguments.is("required") => None,
        _ if optional => Some(quote! { Unset }),
        default => default,
    };
    let default = match default {
        Some(default) => quote! { ::std::option::Option::Some(::trochoid_graph::KnobDefault::#default) },
        None => quote! { ::std::option::Option::None },
    };
    let [hold_keys, accuracy, affects_cost, in_pixels, picture_height] =
        ["hold_keys", "accuracy", "affects_cost", "in_pixels", "picture_height"].map(|flag| arguments.is(flag));
    let unit = arguments.unit.map_or(if in_pixels { "pixels" } else { "" }.to_owned(), |unit| unit.value());
    let places = match arguments.places {
        Some(places) => quote! { ::std::option::Option::Some(::trochoid_graph::Placing::#places) },
        None => quote! { ::std::option::Option::None },
    };
    Ok(FieldCode {
        items: quote! {
            &[::trochoid_graph::Item::Knob(::trochoid_graph::Knob {
                name: #name,
                help: #help,
                unit: #unit,
                takes: ::trochoid_graph::KnobType::#knob_type,
                default: #default,
                animated: #animated,
                hold_keys: #hold_keys,
                accuracy: #accuracy,
                affects_cost: #affects_cost,
                in_pixels: #in_pixels,
                picture_height: #picture_height,
                places: #places,
            })]
        },
        read: quote! { reader.knob() },
    })
}
