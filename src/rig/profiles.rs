//! Profiles: facts about a program, or about all programs of an engine, that Cupola cannot find
//! out.
//!
//! A profile says nothing about the dome. Its keys are defaults of the same keys of rig files.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::reading::problems::{Problems, closest};
use crate::rig::{Camera, Duplicate, Favour, Overlay, read_text, schema};
use std::path::{Path, PathBuf};

/// Values of keys that a rig lacks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Defaults {
    /// `[camera]`.
    pub camera: Camera,
    /// `[overlay]`.
    pub overlay: Overlay,
    /// `views.duplicate`.
    pub duplicate: Duplicate,
    /// `views.favour`.
    pub favour: Favour,
}

impl Default for Defaults {
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            overlay: Overlay { yaw: 0.0, pitch: 0.0, width: 60_f64.to_radians() },
            duplicate: Duplicate::Auto,
            favour: Favour::Balanced,
        }
    }
}

/// A profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Name of the file without `.toml`.
    pub name: String,
    /// File of the profile; `None` = built in.
    pub file: Option<PathBuf>,
    /// Names of the programs to which the profile applies.
    pub executables: Vec<String>,
    /// Prefixes of library names. The profile applies to programs that load one of these libraries.
    pub libraries: Vec<String>,
    /// Instruction for the user of the program, in one line.
    pub hint: Option<String>,
    /// Variables of the environment and their values.
    pub environment: Vec<(String, String)>,
    /// Values for keys that a rig lacks.
    pub defaults: Defaults,
}

/// A profile, and the reason for its choice.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// The profile.
    pub profile: Profile,
    /// Name of the program or of the library to which it applies; `None` = the user requested it.
    pub reason: Option<String>,
}

impl Chosen {
    /// Description of the choice in one line.
    pub fn description(&self) -> String {
        let Profile { name, file, hint, .. } = &self.profile;
        let origin = file.as_ref().map_or_else(|| "built in".to_owned(), |file| file.display().to_string());
        let reason = self.reason.as_ref().map_or_else(String::new, |reason| format!(", for {reason}"));
        let hint = hint.as_ref().map_or_else(String::new, |hint| format!(": {hint}"));
        format!("profile {name} ({origin}{reason}){hint}")
    }
}

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        /// Names and texts of the profiles of the folder `profiles`.
        const BUILT_IN: &[(&str, &str)] =
            &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/profiles/", $name, ".toml")))),*];
    };
}

built_in!["minetest", "openarena", "stellarium", "supertuxkart", "vtk"];

/// Profiles by their names. The user's come before the built-in ones.
#[derive(Clone, Debug, Default)]
pub struct Profiles {
    all: Vec<Profile>,
    /// Errors of the user's files, which are left out.
    errors: Vec<Error>,
}

impl Profiles {
    /// Reads the user's profiles of `folder`. Built-in profiles are added if they have other names.
    pub fn read(folder: Option<&Path>) -> Self {
        let mut profiles = Self::default();
        let entries = folder.and_then(|folder| std::fs::read_dir(folder).ok()).into_iter().flatten().flatten();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
        files.sort();
        for file in files {
            match from_file(&file) {
                Ok(profile) => profiles.all.push(profile),
                Err(error) => profiles.errors.push(error),
            }
        }
        for (name, text) in BUILT_IN {
            if profiles.all.iter().all(|known| known.name != *name) {
                // The tests parse all of them.
                profiles.all.extend(parse(text, name, name));
            }
        }
        profiles
    }

    /// Returns the errors of the user's files, which are left out.
    pub fn errors(&self) -> &[Error] {
        &self.errors
    }

    /// Profile for the program of this name, or otherwise for one of the libraries that it has
    /// loaded.
    pub fn choose(&self, executable: &str, libraries: &[String]) -> Option<Chosen> {
        let chosen = |profile: &Profile, reason: &str| Chosen { profile: profile.clone(), reason: Some(reason.into()) };
        let by_name = self.all.iter().find(|profile| profile.executables.iter().any(|name| name == executable));
        by_name.map(|profile| chosen(profile, executable)).or_else(|| {
            self.all.iter().find_map(|profile| {
                let fits = |library: &&String| profile.libraries.iter().any(|beginning| library.starts_with(beginning));
                Some(chosen(profile, libraries.iter().find(fits)?))
            })
        })
    }

    /// Profile of this name, or in this file.
    ///
    /// # Errors
    /// [`ErrorKind::Io`] if there is neither; [`ErrorKind::InvalidRig`] with every problem of the
    /// file.
    pub fn load(&self, name_or_path: &str) -> Result<Chosen> {
        let profile = match self.all.iter().find(|profile| profile.name == name_or_path) {
            Some(profile) => profile.clone(),
            None if Path::new(name_or_path).exists() => from_file(Path::new(name_or_path))?,
            None => {
                // There is a file of this name, but it is wrong.
                let file = format!("/{name_or_path}.toml:");
                if let Some(error) = self.errors.iter().find(|error| error.message.contains(&file)) {
                    return Err(error.clone());
                }
                let names: Vec<&str> = self.all.iter().map(|profile| profile.name.as_str()).collect();
                let hint = closest(name_or_path, &names).map_or_else(
                    || format!("profiles: {}", names.join(", ")),
                    |name| format!("did you mean `{name}`?"),
                );
                let message = format!("there is no profile and no file {name_or_path:?}; {hint}");
                return Err(Error::new(ErrorKind::Io, message));
            }
        };
        Ok(Chosen { profile, reason: None })
    }
}

fn from_file(file: &Path) -> Result<Profile> {
    let name = file.display().to_string();
    let text = read_text(file, &name, |error| format!("the profile {name} cannot be read: {error}"))?;
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let file = std::path::absolute(file).map_err(|error| Error::new(ErrorKind::Io, format!("{name}: {error}")))?;
    Ok(Profile { file: Some(file), ..parse(&text, &stem, &name)? })
}

fn parse(text: &str, name: &str, file_name: &str) -> Result<Profile> {
    let mut problems = Problems::new(text);
    match schema::profile(text, name, &mut problems) {
        Some(profile) if problems.is_empty() => Ok(profile),
        _ => Err(Error::new(ErrorKind::InvalidRig, problems.message(file_name))),
    }
}

#[cfg(test)]
mod tests {
    use super::{BUILT_IN, Defaults, Profiles, parse};
    use crate::rig::{Duplicate, Overrides, load_with, parse_with};
    use std::path::Path;

    #[test]
    fn every_file_of_the_folder_is_built_in_and_right() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("profiles");
        let entries = std::fs::read_dir(folder).expect("the folder");
        let mut files: Vec<String> =
            entries.map(|e| e.expect("a file").file_name().into_string().expect("text")).collect();
        files.sort();
        let built_in: Vec<String> = BUILT_IN.iter().map(|(name, _)| format!("{name}.toml")).collect();
        assert_eq!(files, built_in);
        for (name, text) in BUILT_IN {
            parse(text, name, name).unwrap_or_else(|error| panic!("{error}"));
        }
    }

    const ALL: &str = "executables = [\"game\"]\nlibraries = [\"libengine\"]\n[environment]\nGAME_FAST = \"1\"\n\
        [camera]\nzoom = 2\nyaw = 10\nlens = [90, 60]\n[views]\nduplicate = \"always\"\n[overlay]\nwidth = 30\n";

    #[test]
    fn the_command_line_beats_the_rig_that_beats_the_profile_that_beats_the_usual() {
        let defaults = parse(ALL, "game", "game.toml").expect("a profile").defaults;
        let rig = "[camera]\nzoom = 3\n[overlay]\npitch = 5\n[[output]]\nkind = \"domemaster\"\n";
        let rig = parse_with(rig, "rig.toml", Path::new(""), &defaults).expect("a rig");
        assert_eq!((rig.camera.zoom, rig.camera.yaw, rig.camera.pitch), (3.0, 10_f64.to_radians(), 0.0));
        assert_eq!(rig.camera.lens, Some([90_f64.to_radians(), 60_f64.to_radians()]));
        assert_eq!((rig.overlay.pitch, rig.overlay.width), (5_f64.to_radians(), 30_f64.to_radians()));
        assert_eq!(rig.views.duplicate, Duplicate::Always);
        let overrides = Overrides { camera: Some("zoom=4,yaw=0".to_owned()), ..Overrides::default() };
        let camera = overrides.apply(rig).expect("right overrides").camera;
        assert_eq!((camera.zoom, camera.yaw), (4.0, 0.0));
        // A preset has no keys of the program.
        let preset = load_with("fisheye", &defaults).expect("a preset");
        assert_eq!((preset.camera, preset.overlay.width), (defaults.camera, 30_f64.to_radians()));
        assert_eq!(load_with("fisheye", &Defaults::default()), crate::rig::load("fisheye"));
    }

    #[test]
    fn mistakes_are_told_by_line_and_key() {
        for (text, expected) in [
            ("hint = \"a\"\n", "a.toml:1: executables: is missing, and `libraries` too"),
            ("executables = \"game\"\n", "a.toml:1: executables: \"game\" does not fit; expected a list of texts"),
            ("executables = [\"\"]\n", "a.toml:1: executables: a list of 1 does not fit"),
            ("executables = [\"a\"]\n[camera]\nzom = 1\n", "a.toml:3: camera.zom: unknown key; did you mean `zoom`?"),
            ("executables = [\"a\"]\n[views]\nquality = 1\n", "a.toml:3: views.quality: unknown key"),
            ("executables = [\"a\"]\n[environment]\nA = 1\n", "a.toml:3: environment.A: 1 is not text"),
            (
                "executables = [\"a\"]\n[environment]\nCUPOLA_RIG = \"a\"\n",
                "a.toml:3: environment.CUPOLA_RIG: is set by",
            ),
            ("libraries = [\"a\"]\n[environment]\nA = \"1\"\n", "a.toml:2: environment: needs `executables`"),
            ("executables = [\"a\"]\n[dome]\n", "a.toml:2: dome: unknown key; it belongs to the rig file"),
            ("executables = \n", "a.toml:1: this is not TOML"),
        ] {
            let error = parse(text, "a", "a.toml").expect_err(text);
            assert!(error.message.starts_with(expected), "{text:?}: {error}");
        }
    }

    #[test]
    fn the_programs_name_beats_its_libraries_and_the_users_files_those_that_are_built_in() {
        let folder = std::env::temp_dir().join(format!("cupola-profiles-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("game.toml"), ALL).expect("a file");
        std::fs::write(folder.join("vtk.toml"), "libraries = [\"libvtkMine\"]\n").expect("a file");
        std::fs::write(folder.join("wrong.toml"), "executables = [\"a\"]\nhints = \"\"\n").expect("a file");
        let profiles = Profiles::read(Some(&folder));
        std::fs::remove_dir_all(&folder).expect("the folder");
        let choose = |name: &str, libraries: &[&str]| {
            let libraries: Vec<String> = libraries.iter().map(|name| (*name).to_owned()).collect();
            profiles.choose(name, &libraries).map(|chosen| (chosen.profile.name, chosen.reason))
        };
        let because = |name: &str, reason: &str| Some((name.to_owned(), Some(reason.to_owned())));
        assert_eq!(choose("game", &["libpandagl.so.1.10"]), because("game", "game"));
        assert_eq!(choose("other", &["libc.so.6", "libengine-2.so"]), because("game", "libengine-2.so"));
        assert_eq!(choose("minetest", &["libengine.so"]), because("minetest", "minetest"));
        assert_eq!(choose("game2", &["engine"]), None);
        assert_eq!(choose("python3", &["libvtkRenderingOpenGL2-9.1.so.1"]), None, "the user's has this name");
        assert_eq!(choose("python3", &["libvtkMine.so"]), because("vtk", "libvtkMine.so"));
        let wrong = profiles.load("wrong").expect_err("a mistake");
        assert!(wrong.message.contains("wrong.toml:2: hints: unknown key; did you mean `hint`?"), "{wrong}");
        assert_eq!(profiles.errors(), [wrong]);
        let none = profiles.load("minetes").expect_err("no such profile");
        assert!(none.message.contains("did you mean `minetest`?"), "{none}");
    }
}
