//! Environment variables through which the library gets the options.

use super::Inspection;
use super::options::Options;
use crate::failure::Failure;
use crate::launch::Environment;
use cupola::rig::{Chosen, Profile};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

impl Options {
    /// Environment variables that configure the library.
    pub(super) fn environment(
        &self,
        profile: Option<&Chosen>,
        inspection: Option<&Inspection>,
    ) -> Result<Environment, Failure> {
        // Wrong options are reported before anything starts.
        let rig = self.rig_with(profile)?;
        let mut environment = settings(self, &self.rig_name())?;
        let name = profile_variable(self.profile_name(), profile);
        environment.extend(name.map(|name| ("CUPOLA_PROFILE", Some(name))));
        environment.extend(self.published(&rig)?.map(|file| ("CUPOLA_PUBLISH", Some(file))));
        environment.extend(self.waits_for_readers.then(|| ("CUPOLA_PUBLISH_WAIT", Some("1".into()))));
        environment.extend(self.published_from.map(|from| ("CUPOLA_PUBLISH_FROM", Some(from.to_string().into()))));
        environment.extend(self.deep_pictures.then(|| ("CUPOLA_PUBLISH_DEPTH", Some("16".into()))));
        environment.extend(self.clock.environment()?);
        if let Some((place, page)) = &self.node {
            environment.push(("CUPOLA_NODE", Some(place.into())));
            environment.push(("CUPOLA_NODE_PAGE", Some(page.into())));
        }
        if let Some(place) = &self.mirrored {
            environment.push(("CUPOLA_NODE", Some(place.into())));
            environment.push(("CUPOLA_MIRRORS", Some("1".into())));
        }
        if let Some(Inspection { output }) = inspection {
            environment.push(("CUPOLA_INSPECT", Some(writable_file(output)?)));
        }
        Ok(environment)
    }
}

/// Environment variables that configure the library.
fn settings(arguments: &Options, rig: &str) -> Result<Environment, Failure> {
    let is_preset = cupola::rig::presets().iter().any(|preset| preset.name == rig);
    let rig = if is_preset { rig.into() } else { absolute(Path::new(rig))? };
    let mut environment: Environment = vec![("CUPOLA_RIG", Some(rig))];
    let mut set = |name, value: Option<OsString>| environment.extend(value.map(|value| (name, Some(value))));
    set("CUPOLA_CAMERA", arguments.camera.as_ref().map(Into::into));
    set("CUPOLA_VIEWER", arguments.viewer.as_ref().map(Into::into));
    set("CUPOLA_CONTENT", arguments.content.as_ref().map(Into::into));
    set("CUPOLA_METHOD", arguments.method.as_ref().map(Into::into));
    set("CUPOLA_SIZE", arguments.size.map(|(width, height)| format!("{width}x{height}").into()));
    set("CUPOLA_FRAMES", arguments.frames.map(|frames| frames.to_string().into()));
    set("CUPOLA_SECONDS", arguments.seconds.map(|seconds| seconds.as_secs_f64().to_string().into()));
    set("CUPOLA_OFFSCREEN", arguments.offscreen.then(|| "1".into()));
    set("CUPOLA_DOMEMASTER", arguments.domemaster.map(|side| side.to_string().into()));
    set("CUPOLA_DUPLICATE", arguments.duplicate.as_ref().map(Into::into));
    set("CUPOLA_OVERLAY", arguments.no_overlay.then(|| "0".into()));
    set("CUPOLA_CULL", arguments.no_cull.then(|| "0".into()));
    set("CUPOLA_MASK", arguments.no_mask.then(|| "0".into()));
    set("CUPOLA_CACHE", arguments.no_cache.then(|| "0".into()));
    let files =
        [("CUPOLA_CAPTURE", &arguments.capture), ("CUPOLA_STATS", &arguments.stats), ("CUPOLA_LOG", &arguments.log)];
    let ending = arguments.capture.as_deref().and_then(Path::extension);
    if ending.is_some_and(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(Failure::usage("--capture: captures are PNG pictures; expected a name that ends in .png"));
    }
    for (name, file) in files {
        set(name, file.as_deref().map(writable_file).transpose()?);
    }
    if let Some(folder) = &arguments.capture_views {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::usage(format!("the folder {} cannot be created: {error}", folder.display())))?;
        set("CUPOLA_CAPTURE_VIEWS", Some(absolute(folder)?));
    }
    Ok(environment)
}

/// Value of the variable that names the profile to the library: `none`, a name or a path; not set
/// if the library has to choose.
fn profile_variable(given: Option<String>, profile: Option<&Chosen>) -> Option<OsString> {
    match profile.map(|chosen| &chosen.profile) {
        Some(Profile { file: Some(file), .. }) => Some(file.into()),
        Some(profile) => Some((&profile.name).into()),
        None => given.map(Into::into),
    }
}

/// Environment variables of a profile. Those that the user has set stay.
pub(super) fn variables(chosen: &Chosen) -> impl Iterator<Item = (&str, &str)> {
    let variables = chosen.profile.environment.iter().map(|(name, value)| (name.as_str(), value.as_str()));
    variables.filter(|(name, _)| std::env::var_os(name).is_none())
}

/// Absolute path of a file to be written. Fails if its folder does not exist, or if it is a folder.
pub(super) fn writable_file(file: &Path) -> Result<OsString, Failure> {
    let path = PathBuf::from(absolute(file)?);
    match path.parent().filter(|folder| folder.is_dir()) {
        Some(_) if path.is_dir() => {
            Err(Failure::usage(format!("{} is a folder; expected the name of a file", file.display())))
        }
        Some(_) => Ok(path.into()),
        None => Err(Failure::usage(format!("{}: the folder of this file does not exist", file.display()))),
    }
}

fn absolute(path: &Path) -> Result<OsString, Failure> {
    let absolute = std::path::absolute(path).map_err(|error| Failure::usage(format!("{}: {error}", path.display())))?;
    Ok(absolute.into())
}

/// Prints commands for a POSIX shell.
pub(super) fn print_environment(environment: &Environment, profile: Option<&Chosen>) {
    let export = |name: &str, value: &str| println!("export {name}='{}'", value.replace('\'', r"'\''"));
    for (name, value) in environment {
        match value {
            Some(value) => export(name, &value.to_string_lossy()),
            None => println!("unset {name}"),
        }
    }
    for (name, value) in profile.into_iter().flat_map(variables) {
        export(name, value);
    }
}
