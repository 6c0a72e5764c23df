//! Values of a JSON text, each with its place for words about what is wrong there.
//!
//! In: parsed JSON. Out: numbers, words, lists, or where which of them was expected. Never: a meaning.

use serde_json::{Map, Value};

/// A place in the object, for words about what is wrong there.
#[derive(Clone, Debug)]
pub struct Reader<'v> {
    path: String,
    /// The value.
    pub value: &'v Value,
}

impl<'v> Reader<'v> {
    /// At the root of a text.
    pub fn new(value: &'v Value) -> Self {
        Reader { path: String::new(), value }
    }

    /// Something else than what was expected stands here.
    ///
    /// # Errors
    /// It is something else.
    pub fn wrong<T>(&self, expected: &str) -> Result<T, String> {
        Err(format!("expected {expected} at {}", if self.path.is_empty() { "its root" } else { &self.path }))
    }

    /// What stands under a name.
    ///
    /// # Errors
    /// It is something else.
    pub fn field(&self, name: &str) -> Result<Reader<'v>, String> {
        let object: Option<&'v Map<String, Value>> = self.value.as_object();
        match object.and_then(|object| object.get(name)) {
            Some(value) => Ok(Reader { path: format!("{}/{name}", self.path), value }),
            None => self.wrong(&format!("`{name}`")),
        }
    }

    /// Every item of a list.
    ///
    /// # Errors
    /// It is something else.
    pub fn list<T>(&self, item: impl Fn(&Reader<'v>) -> Result<T, String>) -> Result<Vec<T>, String> {
        let Some(list) = self.value.as_array() else { return self.wrong("a list") };
        list.iter().map(|value| item(&Reader { path: format!("{}/..", self.path), value })).collect()
    }

    /// A finite number.
    ///
    /// # Errors
    /// It is something else.
    pub fn number(&self) -> Result<f64, String> {
        self.value.as_f64().map_or_else(|| self.wrong("a finite number"), Ok)
    }

    /// A whole number, not below 0.
    ///
    /// # Errors
    /// It is something else.
    pub fn count(&self) -> Result<u64, String> {
        self.value.as_u64().map_or_else(|| self.wrong("a whole number"), Ok)
    }

    /// The number of a row.
    ///
    /// # Errors
    /// It is something else.
    pub fn row(&self) -> Result<u32, String> {
        let row = self.value.as_u64().and_then(|row| u32::try_from(row).ok());
        row.map_or_else(|| self.wrong("the number of a row"), Ok)
    }

    /// True or false.
    ///
    /// # Errors
    /// It is something else.
    pub fn flag(&self) -> Result<bool, String> {
        self.value.as_bool().map_or_else(|| self.wrong("true or false"), Ok)
    }

    /// What stands under a name, if something does.
    pub fn optional(&self, name: &str) -> Option<Reader<'v>> {
        self.field(name).ok().filter(|reader| !reader.value.is_null())
    }

    /// A finite number, or one in words of more digits than a number has: the nearest one.
    ///
    /// # Errors
    /// It is neither.
    pub fn precise(&self) -> Result<f64, String> {
        let number = match self.value.as_str() {
            Some(text) => text.parse().ok().filter(|number: &f64| number.is_finite()),
            None => self.value.as_f64(),
        };
        number.map_or_else(|| self.wrong("a number"), Ok)
    }

    /// Three such numbers.
    ///
    /// # Errors
    /// They are not three.
    pub fn vector(&self) -> Result<[f64; 3], String> {
        let numbers = self.list(Reader::precise)?;
        <[f64; 3]>::try_from(numbers).or_else(|_| self.wrong("three numbers"))
    }

    /// Words.
    ///
    /// # Errors
    /// It is something else.
    pub fn text(&self) -> Result<String, String> {
        self.value.as_str().map_or_else(|| self.wrong("text"), |text| Ok(text.to_owned()))
    }
}
