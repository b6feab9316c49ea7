//! Files and environment variables that make libglvnd and the Vulkan loader load Cupola: a folder
//! with the library under the names that they expect, and variables that refer to it.

use super::{Environment, library, probe};
use crate::failure::Failure;
use std::ffi::OsString;
use std::os::unix::fs::{DirBuilderExt, symlink};
use std::path::{Path, PathBuf};

/// Folders in which libglvnd looks for EGL vendors.
const EGL_VENDOR_FOLDERS: [&str; 2] = ["/etc/glvnd/egl_vendor.d", "/usr/share/glvnd/egl_vendor.d"];

/// Name of the Vulkan layer.
pub const VULKAN_LAYER: &str = "VK_LAYER_CUPOLA_dome";

/// A private folder that is removed when this is dropped.
pub struct Scratch(PathBuf);

impl Scratch {
    /// Creates the folder, readable by this user only.
    pub fn new() -> Result<Self, Failure> {
        let parent = std::env::temp_dir();
        let mut last = None;
        for attempt in 0..1000 {
            let path = parent.join(format!("cupola-{}-{attempt}", std::process::id()));
            // This fails if the folder exists: a folder of another user must not be used.
            match std::fs::DirBuilder::new().mode(0o700).create(&path) {
                Ok(()) => return Ok(Self(path)),
                Err(error) => last = Some(error),
            }
        }
        let why = last.map_or_else(String::new, |error| error.to_string());
        Err(Failure::new(format!("no private folder can be created in {}: {why}", parent.display())))
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_dir_all(&self.0) {
            eprintln!("cupola: {} was not removed: {error}", self.0.display());
        }
    }
}

/// The folder with the files for the loaders.
pub struct Loader {
    folder: PathBuf,
    library: PathBuf,
}

impl Loader {
    /// Creates the files in `folder`, which is empty and is removed when the program ends.
    pub fn temporary(folder: &Path) -> Result<Self, Failure> {
        let library = library::find()?;
        let folder = folder.join("lib");
        std::fs::create_dir_all(&folder).map_err(|error| cannot_write(&folder, &error))?;
        let link = folder.join("libGLX_cupola.so.0");
        symlink(&library, &link).map_err(|error| cannot_write(&link, &error))?;
        Ok(Self { folder, library })
    }

    /// Creates the files in the user's cache folder, for environments that are used later.
    pub fn persistent() -> Result<Self, Failure> {
        let folder = cupola::runtime::cache::user_folder().ok_or_else(|| {
            Failure::new("neither XDG_CACHE_HOME nor HOME is set: there is no folder for cached files")
        })?;
        if folder.join("lib").exists() {
            std::fs::remove_dir_all(folder.join("lib")).map_err(|error| cannot_write(&folder, &error))?;
        }
        Self::temporary(&folder)
    }

    /// Environment variables that make libglvnd and the Vulkan loader use Cupola. `display` holds
    /// the variables that select the display of the program.
    pub fn environment(&self, display: &Environment) -> Result<Environment, Failure> {
        let mut environment = self.glx(display);
        environment.extend(self.egl()?);
        environment.extend(self.vulkan()?);
        Ok(environment)
    }

    fn glx(&self, display: &Environment) -> Environment {
        if let Some(why) = library::refusal(&self.library, "__glx_Main") {
            eprintln!("cupola: programs that use GLX will not be corrected: {}: {why}", self.library.display());
            return Vec::new();
        }
        let real = real_glx_vendor(display);
        let mut path: OsString = self.folder.clone().into();
        if let Some(rest) = std::env::var_os("LD_LIBRARY_PATH").filter(|rest| !rest.is_empty()) {
            path.push(":");
            path.push(rest);
        }
        vec![
            ("__GLX_VENDOR_LIBRARY_NAME", Some("cupola".into())),
            ("CUPOLA_GLX_REAL", Some(real)),
            ("LD_LIBRARY_PATH", Some(path)),
        ]
    }

    /// Variables for libEGL. libEGL loads only the vendors in its list. A vendor that cannot be
    /// loaded would leave the program without EGL, so the list is replaced only if the library can
    /// be loaded.
    fn egl(&self) -> Result<Environment, Failure> {
        let warn = |why: &str| eprintln!("cupola: programs that use EGL will not be corrected: {why}");
        if let Some(why) = library::refusal(&self.library, "__egl_Main") {
            warn(&format!("{}: {why}", self.library.display()));
            return Ok(Vec::new());
        }
        let vendors = egl_vendors();
        if vendors.is_empty() {
            warn("libglvnd lists no EGL vendor");
            return Ok(Vec::new());
        }
        let mut files = Vec::new();
        for index in 0..vendors.len() {
            // libEGL refuses a vendor whose library has already been loaded, so each of several
            // vendors needs a copy. A copy finds its vendor by the number in its file name.
            let library = if vendors.len() == 1 {
                self.library.clone()
            } else {
                let copy = self.folder.join(format!("libEGL_cupola_{index}.so"));
                std::fs::copy(&self.library, &copy).map_err(|error| cannot_write(&copy, &error))?;
                copy
            };
            let json = serde_json::json!({
                "file_format_version": "1.0.0",
                "ICD": { "library_path": library.to_string_lossy() },
            });
            let file = self.folder.join(format!("{index:02}_cupola.json"));
            std::fs::write(&file, json.to_string()).map_err(|error| cannot_write(&file, &error))?;
            files.push(file.into_os_string());
        }
        Ok(vec![
            ("__EGL_VENDOR_LIBRARY_FILENAMES", Some(files.join(":".as_ref()))),
            ("CUPOLA_EGL_REAL", Some(vendors.join(":".as_ref()))),
        ])
    }

    /// Variables for the Vulkan loader, which reads the description of the layer from the folder.
    /// It skips layers that it cannot load.
    fn vulkan(&self) -> Result<Environment, Failure> {
        if let Some(why) = library::refusal(&self.library, "vkNegotiateLoaderLayerInterfaceVersion") {
            eprintln!("cupola: programs that use Vulkan will not be corrected: {}: {why}", self.library.display());
            return Ok(Vec::new());
        }
        let file = self.folder.join("VkLayer_cupola.json");
        let json = serde_json::json!({
            "file_format_version": "1.1.2",
            "layer": {
                "name": VULKAN_LAYER,
                "type": "GLOBAL",
                "library_path": self.library.to_string_lossy(),
                // Loaders skip layers with a lower version than the program asks for, so this is
                // above all versions.
                "api_version": "1.4.999",
                "implementation_version": "1",
                "description": "Puts the program on a dome",
            },
        });
        std::fs::write(&file, json.to_string()).map_err(|error| cannot_write(&file, &error))?;
        // Cupola comes after layers that the user has enabled, such as the validation layer: nearer
        // to the driver.
        let list = |name: &str, own: OsString, own_first: bool| {
            let rest = std::env::var_os(name).filter(|rest| !rest.is_empty());
            let parts: Vec<OsString> = match rest {
                Some(rest) if own_first => vec![own, rest],
                Some(rest) => vec![rest, own],
                None => vec![own],
            };
            Some(parts.join(":".as_ref()))
        };
        Ok(vec![
            ("VK_ADD_LAYER_PATH", list("VK_ADD_LAYER_PATH", self.folder.clone().into(), true)),
            ("VK_INSTANCE_LAYERS", list("VK_INSTANCE_LAYERS", VULKAN_LAYER.into(), false)),
        ])
    }
}

/// The GLX vendor that the program would get without Cupola: the one in the environment, or the
/// only one installed, or the one that a test program gets on this display.
fn real_glx_vendor(display: &Environment) -> OsString {
    let named = |name: &str| std::env::var_os(name).filter(|vendor| !vendor.is_empty() && vendor != "cupola");
    if let Some(vendor) = named("CUPOLA_GLX_REAL").or_else(|| named("__GLX_VENDOR_LIBRARY_NAME")) {
        return vendor;
    }
    if let [only] = &installed_glx_vendors()[..] {
        return only.into();
    }
    let answer = probe::ask(probe::Way::Glx, display).ok();
    answer.as_ref().and_then(|answer| answer.glx_vendor()).unwrap_or("mesa").into()
}

/// Names of the GLX vendors in the usual library folders. Mostly there is only one, which saves the
/// slow start of a driver in a test program.
fn installed_glx_vendors() -> Vec<String> {
    let architecture = format!("/usr/lib/{}-linux-gnu", std::env::consts::ARCH);
    let folders = [architecture.as_str(), "/usr/lib64", "/usr/lib", "/usr/local/lib"];
    let entries = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let vendor = |name: String| name.strip_prefix("libGLX_")?.strip_suffix(".so.0").map(str::to_owned);
    let mut vendors: Vec<String> =
        names.filter_map(vendor).filter(|name| name != "indirect" && name != "cupola").collect();
    vendors.sort();
    vendors.dedup();
    vendors
}

/// Libraries of the system's EGL vendors in the order of libglvnd, described in its
/// icd_enumeration.md.
fn egl_vendors() -> Vec<OsString> {
    let listed = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let files: Vec<PathBuf> = match (listed("__EGL_VENDOR_LIBRARY_FILENAMES"), listed("__EGL_VENDOR_LIBRARY_DIRS")) {
        (Some(files), _) => std::env::split_paths(&files).collect(),
        (None, Some(folders)) => std::env::split_paths(&folders).flat_map(|folder| json_files(&folder)).collect(),
        (None, None) => EGL_VENDOR_FOLDERS.iter().flat_map(|folder| json_files(Path::new(folder))).collect(),
    };
    files.iter().filter_map(|file| vendor_library(file)).collect()
}

/// The JSON files of a folder, sorted by name.
fn json_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|kind| kind == "json")).collect();
    files.sort();
    files
}

/// The library that the JSON file of a vendor names. A name with a slash is relative to the file.
fn vendor_library(file: &Path) -> Option<OsString> {
    let text = std::fs::read_to_string(file).ok()?;
    let json: serde_json::Value = serde_json::from_str(&text).ok()?;
    let library = json.get("ICD")?.get("library_path")?.as_str()?;
    if library.contains('/') { Some(file.parent()?.join(library).into()) } else { Some(library.into()) }
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(format!("{} cannot be written: {error}", path.display()))
}
