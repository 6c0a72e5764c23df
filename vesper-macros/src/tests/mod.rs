//! What the macros make of text: the expansions, and the table of mistakes.

mod expansions;
mod mistakes;

use proc_macro2::TokenStream;

/// Text as tokens.
fn tokens(text: &str) -> TokenStream {
    text.parse().unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Tokens without spaces, so that fragments compare however they are printed.
fn plain(tokens: &TokenStream) -> String {
    tokens.to_string().split_whitespace().collect()
}
