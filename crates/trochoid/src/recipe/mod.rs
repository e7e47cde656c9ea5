//! Recipes: the weights of a picture, one plane for each color that it is mixed from.
//!
//! A picture is Σ ωᵢCᵢ, and its weights ω do not depend on its colors C. With the weights in a file, it is painted in
//! other colors without being rendered again. A recipe is an EXR file with one layer, `recipe`, that has a channel for
//! each color, so that other programs read each as a mask. What comes from control images is a layer `images`: R, G and
//! B in the working space, already weighted, and in A the weight of all images together. The weights, with A, are ≥ 0
//! and sum to exactly 1 as stored. Metadata `trochoid:recipe` have the colors.
//!
//! [`PackedRecipe`] holds a recipe in memory, for programs that paint it in other colors while one looks.

#[cfg(feature = "io")]
mod header;
mod info;
mod packed;
#[cfg(feature = "io")]
mod reader;
mod rows;
mod tiles;
#[cfg(feature = "io")]
mod whole;

#[cfg(feature = "io")]
pub use header::RecipeError;
#[cfg(feature = "io")]
pub(crate) use header::{KEY, LATE};
#[cfg(feature = "io")]
pub(crate) use info::LAYER;
pub use info::{RecipeInfo, Rounding};
pub use packed::{PackError, PackedRecipe};
#[cfg(feature = "io")]
pub use reader::{RecipeReader, RecipeScratch};
#[cfg(feature = "io")]
pub(crate) use rows::RecipeRows;
#[cfg(feature = "io")]
pub use whole::Recipe;
