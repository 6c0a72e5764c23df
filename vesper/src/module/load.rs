//! Finding modules, and what they are to a program.
//!
//! In: names, and folders to look in. Out: [`Module`]s, each opened once and for good. Never: a name that leads out of these folders.

use super::abi;
use super::column::Columns;
use super::declared::{Declared, copied, declared};
use super::instance::Instance;
use super::link::LinkLaws;
use super::native::NativeRows;
use super::pair::Pairs;
use super::row::Rows;
use crate::backend::{Compile, Compiled, Kernel};
use crate::error::{Fault, Faults, nearest};
use crate::law::{Shape, Signature};
use crate::real::{DoubleDouble, Scalar};
use core::ffi::CStr;
use libloading::Library;
use std::collections::BTreeMap;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::error::Error;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// The environment's variable of folders with modules, separated as those of programs are.
pub const PATH_VARIABLE: &str = "VESPER_LAW_PATH";

/// Folders that modules are looked for in, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LawPath {
    folders: Vec<PathBuf>,
}

impl LawPath {
    /// These folders.
    pub fn new<F: Into<PathBuf>>(folders: impl IntoIterator<Item = F>) -> Self {
        LawPath { folders: folders.into_iter().map(Into::into).collect() }
    }

    /// Behind them, those of the environment's `VESPER_LAW_PATH`.
    #[must_use]
    pub fn and_environment(mut self) -> Self {
        if let Some(folders) = std::env::var_os(PATH_VARIABLE) {
            self.folders.extend(std::env::split_paths(&folders).filter(|folder| !folder.as_os_str().is_empty()));
        }
        self
    }

    /// The folders.
    pub fn folders(&self) -> &[PathBuf] {
        &self.folders
    }

    /// The names of all files that could be modules, in order.
    pub fn names(&self) -> Vec<String> {
        let files = self.folders.iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten().flatten();
        let name = |file: fs::DirEntry| module_name(&file.path());
        let mut names: Vec<String> = files.filter_map(name).collect();
        names.sort();
        names.dedup();
        names
    }

    /// The module of this name: `my_laws` is `libmy_laws.so` (or what libraries are called here), in the first folder that has it.
    ///
    /// # Errors
    /// There is none, or it is no module that this version can use.
    ///
    /// # Safety
    /// Its code runs in this process, and does what `vesper_law.h` says: whoever put modules into these folders is trusted.
    pub unsafe fn module(&self, name: &str) -> Result<&'static Module, Faults> {
        let plain = !name.is_empty() && name.chars().all(|letter| letter.is_alphanumeric() || "_-".contains(letter));
        if !plain {
            let reason = "a module is called by its name, without folder, `lib` and ending";
            return Err(fault(name, reason.to_owned()));
        }
        let files = [format!("{DLL_PREFIX}{name}{DLL_SUFFIX}"), format!("{name}{DLL_SUFFIX}")];
        let found = self
            .folders
            .iter()
            .flat_map(|folder| files.iter().map(|file| folder.join(file)))
            .find(|path| path.is_file());
        let Some(path) = found else {
            return Err(fault(name, self.missing(name, &files[0])));
        };
        // SAFETY: passed on to the caller.
        unsafe { Module::open(&path) }
    }

    fn missing(&self, name: &str, file: &str) -> String {
        if self.folders.is_empty() {
            return format!("there is no folder to look for {file} in: give one, or set {PATH_VARIABLE}");
        }
        let folders: Vec<String> = self.folders.iter().map(|folder| folder.display().to_string()).collect();
        let names = self.names();
        let near = nearest(name, names.iter().map(String::as_str));
        let mend = match (near, names.is_empty()) {
            (Some(near), _) => format!("; did you mean {near}?"),
            (None, true) => "; no module is there".to_owned(),
            (None, false) => format!("; there are: {}", names.join(", ")),
        };
        format!("there is no {file} in {}{mend}", folders.join(", "))
    }
}

/// The name of the module in a file of this path, if it could be one.
fn module_name(path: &Path) -> Option<String> {
    let file = path.file_name().and_then(OsStr::to_str)?;
    let name = file.strip_suffix(DLL_SUFFIX)?;
    Some(name.strip_prefix(DLL_PREFIX).unwrap_or(name).to_owned())
}

fn fault(module: &str, reason: String) -> Faults {
    Fault::Module { module: module.to_owned(), reason }.into()
}

/// A library of laws, open for the life of the program: what it says of itself, its laws, and those of them that cannot be used.
#[derive(Debug)]
pub struct Module {
    name: String,
    path: PathBuf,
    build: String,
    laws: Vec<Declared>,
    refused: Vec<Fault>,
}

impl Module {
    /// Opens the library at a path, or finds it open.
    ///
    /// # Errors
    /// It is not there, or no module that this version can use. Of a module in which some laws are wrong, the others can be used:
    /// [`Module::refused`].
    ///
    /// # Safety
    /// As for [`LawPath::module`].
    pub unsafe fn open(path: &Path) -> Result<&'static Module, Faults> {
        static OPEN: Mutex<BTreeMap<PathBuf, &'static Module>> = Mutex::new(BTreeMap::new());
        let name = module_name(path).unwrap_or_else(|| path.display().to_string());
        let path = fs::canonicalize(path).map_err(|error| fault(&name, format!("{}: {error}", path.display())))?;
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = open.get(&path) {
            return Ok(known);
        }
        // SAFETY: passed on to the caller.
        let module: &'static Module =
            Box::leak(Box::new(unsafe { loaded(&name, &path) }.map_err(|reason| fault(&name, reason))?));
        for refused in &module.refused {
            log::warn!("{refused}");
        }
        open.insert(path, module);
        Ok(module)
    }

    /// The name that scenes call it by.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Who built it, as it says.
    pub fn build(&self) -> &str {
        &self.build
    }

    /// Its laws.
    pub fn signatures(&self) -> impl Iterator<Item = &Signature> {
        self.laws.iter().map(|law| &law.signature)
    }

    /// What is wrong with its other laws.
    pub fn refused(&self) -> &[Fault] {
        &self.refused
    }

    /// A law of this module, with the defaults of its parameters.
    ///
    /// # Errors
    /// It has none of this name that can be used.
    pub fn law(&'static self, name: &str) -> Result<ModuleLaw, Fault> {
        let found = self.laws.iter().find(|law| law.signature.name == name);
        let declared = found.ok_or_else(|| {
            let names = || self.signatures().map(|law| law.name);
            let mut reason = match nearest(name, names()) {
                Some(near) => format!("it has no law {name}; did you mean {near}?"),
                None if names().next().is_none() => format!("it has no law {name}, and no other that can be used"),
                None => format!("it has no law {name}; there are: {}", names().collect::<Vec<_>>().join(", ")),
            };
            for refused in &self.refused {
                reason += &format!("; refused: {refused}");
            }
            Fault::Module { module: self.name.clone(), reason }
        })?;
        let default = |parameter: &crate::law::Parameter| match parameter.default {
            Some(default) => default[..parameter.width].to_vec(),
            None => vec![f64::NAN; parameter.width],
        };
        Ok(ModuleLaw { declared, parameters: declared.signature.parameters.iter().flat_map(default).collect() })
    }
}

/// # Safety
/// As for [`LawPath::module`].
unsafe fn loaded(name: &str, path: &Path) -> Result<Module, String> {
    let with_causes = |error: &libloading::Error| {
        let mut text = error.to_string();
        let mut cause = error.source();
        while let Some(error) = cause {
            text += &format!(": {error}");
            cause = error.source();
        }
        text
    };
    // SAFETY: passed on to the caller.
    let library = unsafe { Library::new(path) }
        .map_err(|error| format!("it is no library that can be loaded: {}", with_causes(&error)))?;
    // Never closed: a panic, or a thread of the module's, would keep a part of it here, and laws are known by their tables.
    let library = core::mem::ManuallyDrop::new(library);
    type Entry = unsafe extern "C" fn() -> *const abi::Module;
    let symbol = |version: u32| -> Result<Entry, libloading::Error> {
        let symbol = format!("vesper_module_v{version}");
        // SAFETY: passed on to the caller.
        unsafe { library.get::<Entry>(symbol.as_bytes()) }.map(|entry| *entry)
    };
    let entry = symbol(abi::VERSION).map_err(|error| {
        let version = abi::VERSION;
        match (1..100).find(|&other| symbol(other).is_ok()) {
            Some(other) => {
                format!("it speaks version {other} of the interface, and this host version {version}: build it again")
            }
            None => format!("it is a library, but no module: it exports no {} ({})", abi::SYMBOL, with_causes(&error)),
        }
    })?;
    // SAFETY: passed on to the caller.
    let table = unsafe { entry() };
    if table.is_null() {
        return Err(format!("{} returned no table", abi::SYMBOL));
    }
    // SAFETY: a table begins with two numbers.
    let (version, size) = unsafe { ((*table).abi, (*table).struct_size as usize) };
    if version != abi::VERSION {
        return Err(format!(
            "its table is of version {version}, and this host speaks {}: build it again",
            abi::VERSION
        ));
    }
    if size < MODULE_SIZE {
        return Err(format!(
            "its table is cut off: {size} bytes, and {} are needed: set `struct_size` to `sizeof(vesper_module)`",
            MODULE_SIZE
        ));
    }
    // SAFETY: it has these bytes, of which zeros are a value.
    let table = unsafe { &copied(table, size) };
    if table.law_count > MOST_LAWS || table.law_count > 0 && table.laws.is_null() {
        return Err(format!("it says that it has {} laws: at most {MOST_LAWS} can be, in a list", table.law_count));
    }
    let build = if table.build.is_null() {
        String::new()
    } else {
        // SAFETY: a text ends with a zero.
        unsafe { CStr::from_ptr(table.build) }.to_string_lossy().into_owned()
    };
    let (mut laws, mut refused): (Vec<Declared>, Vec<Fault>) = (Vec::new(), Vec::new());
    for number in 0..table.law_count {
        // SAFETY: there are so many pointers.
        match unsafe { declared(*table.laws.add(number)) } {
            Ok(law) if laws.iter().any(|known| known.signature.name == law.signature.name) => {
                let reason = format!("it has two laws {}: the second one cannot be called", law.signature.name);
                refused.push(Fault::Module { module: name.to_owned(), reason });
            }
            Ok(law) => laws.push(law),
            Err(wrong) => {
                refused.extend(wrong.into_iter().map(|reason| Fault::Module { module: name.to_owned(), reason }));
            }
        }
    }
    Ok(Module { name: name.to_owned(), path: path.to_owned(), build, laws, refused })
}

/// Bytes of a table of version 1.
const MODULE_SIZE: usize = core::mem::offset_of!(abi::Module, laws) + size_of::<usize>();

/// More laws in one module are a slip.
const MOST_LAWS: usize = 4096;

/// A law of a module, with its parameters.
#[derive(Clone, Debug)]
pub struct ModuleLaw {
    declared: &'static Declared,
    parameters: Vec<f64>,
}

impl ModuleLaw {
    /// What it touches, and its parameters.
    pub fn signature(&self) -> &'static Signature {
        &self.declared.signature
    }

    /// The same with another value of a parameter: a number, or the components of a vector.
    ///
    /// # Errors
    /// It has no such parameter, or one of another width.
    pub fn with(mut self, parameter: &str, value: &[f64]) -> Result<Self, Fault> {
        let (law, mut at) = (self.declared.signature.name, 0);
        let wrong = |reason: String| Fault::Parameter { law: law.to_owned(), reason };
        for known in self.declared.signature.parameters {
            if known.name == parameter {
                if value.len() != known.width {
                    return Err(wrong(format!(
                        "parameter {parameter} has {} components, and {} are given",
                        known.width,
                        value.len()
                    )));
                }
                self.parameters[at..at + known.width].copy_from_slice(value);
                return Ok(self);
            }
            at += known.width;
        }
        let names = || self.declared.signature.parameters.iter().map(|known| known.name);
        Err(wrong(match nearest(parameter, names()) {
            Some(near) => format!("it has no parameter {parameter}; did you mean {near}?"),
            None if names().next().is_none() => format!("it has no parameter {parameter}, nor any other"),
            None => format!("it has no parameter {parameter}; there are: {}", names().collect::<Vec<_>>().join(", ")),
        }))
    }

    /// The same with all components of its parameters, in declared order.
    ///
    /// # Errors
    /// There are more or fewer.
    pub fn with_all(mut self, values: &[f64]) -> Result<Self, Fault> {
        let (given, needed) = (values.len(), self.parameters.len());
        if given != needed {
            let reason = format!("its parameters have {needed} components, and {given} are given");
            return Err(Fault::Parameter { law: self.declared.signature.name.to_owned(), reason });
        }
        self.parameters.copy_from_slice(values);
        Ok(self)
    }

    fn compiled<P: Scalar>(&self) -> Compiled<P> {
        let Declared { signature, shape, table, .. } = self.declared;
        // SAFETY: whoever opened the module promised this.
        let instance = Arc::new(unsafe { Instance::new(self.declared, &self.parameters) });
        let kernel = match shape {
            Shape::Row => match NativeRows::new::<P>(&instance) {
                Some(rows) => Kernel::Row(Arc::new(rows)),
                None => Kernel::Row(Arc::new(Rows::new::<P>(instance.clone()))),
            },
            Shape::Pair => Kernel::Pair(Arc::new(Pairs(instance.clone()))),
            Shape::Link => Kernel::Link(Box::new(LinkLaws(instance.clone()))),
            Shape::Column => Kernel::Column(Box::new(Columns(instance.clone()))),
        };
        Compiled {
            signature: *signature,
            energy: table.energy.is_some(),
            parameters: self.parameters.clone(),
            foreign: Some(instance),
            kernel,
        }
    }
}

impl Compile for ModuleLaw {
    fn compile_f32(&self) -> Compiled<f32> {
        self.compiled()
    }
    fn compile_f64(&self) -> Compiled<f64> {
        self.compiled()
    }
    fn compile_double_double(&self) -> Compiled<DoubleDouble> {
        self.compiled()
    }
}
