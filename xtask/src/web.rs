//! The browser page as static files: `target/site`.

use std::collections::hash_map::DefaultHasher;
use std::ffi::OsStr;
use std::hash::{Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use crate::Failure;
use crate::places::{cargo, command, root, run, slipfit, succeeds, target};

/// The compilation target for browsers.
pub(crate) const WASM: &str = "wasm32-unknown-unknown";
/// Debian's compiler for the web, for machines without `rustup target add`.
const DEBIAN: &str = "apt install rustc-web cargo-web rust-web-src lld-19";
/// Files that are not part of the page.
const EXCLUDED: [&str; 7] = [
    "tests",
    "node_modules",
    "package.json",
    "package-lock.json",
    "README.md",
    "tsconfig.json",
    "types.d.ts",
];
/// The glue program is a separate workspace, see there.
const GLUE: &str = "xtask/glue/Cargo.toml";
/// Examples of the repository that the page offers.
const EXAMPLES: [&str; 5] = [
    "classroom_pendulum.csv",
    "tuning_fork_9nN.csv",
    "tuning_fork_9nN_sweep.csv",
    "tuning_fork_free_sweep.csv",
    "tuning_fork_9nN_levels.csv",
];
/// Maximum compressed size of the first view: two seconds on a slow connection.
pub(crate) const MOST_PACKED: u64 = 1_500_000;
/// Packages without loops over samples: built for size, which saves 120 kB of download.
const BUILT_FOR_SIZE: [&str; 10] = [
    "cfb",
    "encoding_rs",
    "owned_ttf_parser",
    "quick-xml",
    "serde_json",
    "slipfit-io",
    "statrs",
    "ttf-parser",
    "typed-path",
    "zip",
];
/// Texts and forms: built for size regardless of run time.
const WITHOUT_LOOPS: [&str; 2] = ["slipfit-report", "slipfit-wasm"];
/// Packages that compute sums over samples: built with 128-bit SIMD, which every browser has. Building all packages
/// this way would add 170 kB.
const WITH_SIMD: [&str; 1] = ["slipfit"];
/// Flags: SIMD loops, and pairs of numbers loaded together; the LLVM of this compiler crashes when it vectorises
/// straight-line sums. Only the shortest functions are inlined: this saves 56 kB of download.
const SIMD_FLAGS: &str = r#"["-Ctarget-feature=+simd128", "-Cllvm-args=-slp-vectorize-hor=false", "-Cllvm-args=-inline-threshold=4"]"#;
/// Module fetched with the first file that needs it, not with the page.
const FORMATS_MODULE: &str = "slipfit_wasm_formats";

/// The built site.
pub(crate) struct Site {
    pub(crate) folder: PathBuf,
    /// Size of the first view in bytes, compressed by gzip as servers do.
    pub(crate) packed: u64,
}

/// Toolchain that builds the core for browsers.
pub(crate) enum Toolchain {
    /// `rustup target add wasm32-unknown-unknown`.
    Rustup,
    /// Debian's rustc-web; the standard library is built from source.
    Debian,
}

impl Toolchain {
    /// The toolchain of this machine, or a message about what is missing.
    pub(crate) fn find() -> Result<Self, String> {
        let output = command("rustc").args(["--print", "target-libdir", "--target", WASM]).output();
        let installed = output.is_ok_and(|output| {
            let library = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
            output.status.success() && library.is_dir()
        });
        if installed {
            return Ok(Self::Rustup);
        }
        // The package that contains the sources of the standard library changes its name with the version.
        let sysroot = command("/usr/bin/rustc").args(["--print", "sysroot"]).output();
        let has_sources = sysroot.is_ok_and(|output| {
            let sysroot = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
            output.status.success() && sysroot.join("lib/rustlib/src/rust/library").is_dir()
        });
        if has_sources && succeeds(command("wasm-ld-19").arg("--version")) {
            return Ok(Self::Debian);
        }
        Err(format!("`rustup target add {WASM}` (or on Debian `{DEBIAN}`) is missing"))
    }

    fn cargo(&self) -> Command {
        let mut build = match self {
            Self::Rustup => cargo(),
            Self::Debian => {
                let mut build = command("/usr/bin/cargo");
                build.env("RUSTC", "/usr/bin/rustc");
                build.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld-19");
                build
            }
        };
        // Per-package flags are an option of nightly compilers.
        build.env("RUSTC_BOOTSTRAP", "1").args(["build", "--release", "-Zprofile-rustflags"]);
        if matches!(self, Self::Debian) {
            build.arg("-Zbuild-std=std,panic_abort");
        }
        for package in WITH_SIMD {
            build.args(["--config", &format!("profile.release.package.{package}.rustflags={SIMD_FLAGS}")]);
            build.args(["--config", &format!("profile.release.package.{package}.opt-level=2")]);
        }
        for package in BUILT_FOR_SIZE {
            build.args(["--config", &format!("profile.release.package.{package}.opt-level=\"s\"")]);
        }
        for package in WITHOUT_LOOPS {
            build.args(["--config", &format!("profile.release.package.{package}.opt-level=\"z\"")]);
        }
        build
    }
}

/// The system's Chromium, or the one named by `CHROMIUM`.
pub(crate) fn chromium() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let usual =
        ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].map(PathBuf::from);
    named.into_iter().chain(usual).find(|path| path.is_file())
}

/// Builds the site and prints what it contains.
pub(crate) fn chore() -> Result<ExitCode, Failure> {
    let site = build(&Toolchain::find()?)?;
    println!("{}: {} kB packed at the first view", site.folder.display(), site.packed / 1000);
    println!(
        "any server of static files serves it, such as python3 -m http.server -d {}",
        site.folder.display()
    );
    Ok(ExitCode::SUCCESS)
}

/// Builds the site.
///
/// # Errors
/// If a required program is missing or fails.
pub(crate) fn build(toolchain: &Toolchain) -> Result<Site, Failure> {
    let folder = target()?.join("site");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    let source = root().join("web");
    copy(&source, &folder)?;
    let glue = glue()?;
    for (name, features) in [("slipfit_wasm", None), (FORMATS_MODULE, Some("formats"))] {
        module(toolchain, &glue, &folder, name, features)?;
    }
    examples(&folder.join("examples"))?;
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        std::fs::copy(root().join(name), folder.join(name))?;
    }
    let first = first_view(&folder)?;
    fill_service_worker(&folder, &first)?;
    let mut packed = 0;
    for file in first.iter().map(|name| folder.join(name)) {
        packed += gzipped(&file)?;
    }
    Ok(Site { folder, packed })
}

/// One build of the core for the page. binaryen's wasm-opt is not used: it took 50 s per build, saved 15 kB of
/// download, and made the first answer slower.
fn module(
    toolchain: &Toolchain,
    glue: &Path,
    folder: &Path,
    name: &str,
    features: Option<&str>,
) -> Result<(), Failure> {
    let mut build = toolchain.cargo();
    build.args(["--package", "slipfit-wasm", "--lib", "--no-default-features", "--target", WASM]);
    run(build.args(features.map(|features| format!("--features={features}"))))?;
    let built = target()?.join(WASM).join("release").join("slipfit_wasm.wasm");
    run(command(glue).arg(built).arg(name).arg(folder))
}

/// The program that writes the glue between JavaScript and a module: `xtask/glue`, built if it is missing.
fn glue() -> Result<PathBuf, Failure> {
    let folder = target()?.join("tools").join("glue");
    let mut build = cargo();
    build.args(["build", "--quiet", "--locked", "--manifest-path", GLUE]);
    run(build.env("CARGO_TARGET_DIR", &folder))?;
    Ok(folder.join("debug/slipfit-glue").with_extension(std::env::consts::EXE_EXTENSION))
}

/// Copies the files of a folder and its subfolders.
fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if EXCLUDED.iter().any(|excluded| name == *excluded) {
            continue;
        }
        if entry.file_type()?.is_dir() {
            copy(&entry.path(), &to.join(&name))?;
        } else {
            std::fs::copy(entry.path(), to.join(&name))?;
        }
    }
    Ok(())
}

/// The examples of the repository, and two generated by the command.
fn examples(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    for name in EXAMPLES {
        std::fs::copy(root().join("examples").join(name), folder.join(name))?;
    }
    let slipfit = slipfit()?;
    let simulated = |arguments: &str| -> Result<String, Failure> {
        let output = command(&slipfit).args(["simulate", "decay"]).args(arguments.split(' ')).output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        }
        Ok(String::from_utf8(output.stdout)?)
    };
    let viscous = "--frequency-hz 4 --q 80 --unit mm --amplitude 5 --duration 30 --rate-hz 24 --noise-rms 0.01 --seed 11";
    std::fs::write(folder.join("viscous_decay.csv"), simulated(viscous)?)?;
    let strong = "--frequency-hz 80 --q 400 --unit V --amplitude 1 --duration 2 --rate-hz 800 --noise-rms 0.002 --seed 12";
    let weak = "--frequency-hz 97 --q 500 --unit V --amplitude 0.4 --duration 2 --rate-hz 800";
    std::fs::write(folder.join("two_modes.csv"), sum(&simulated(strong)?, &simulated(weak)?)?)?;
    Ok(())
}

/// The sum of two records with the same time stamps.
fn sum(one: &str, other: &str) -> Result<String, Failure> {
    let rows = |text: &'_ str| -> Vec<String> {
        text.lines().filter(|line| !line.starts_with('#')).skip(1).map(str::to_owned).collect()
    };
    let mut text = String::from("time (s),displacement (V)\n");
    for (one, other) in rows(one).iter().zip(rows(other)) {
        let cell = |row: &str, i: usize| row.split(',').nth(i).and_then(|cell| cell.parse::<f64>().ok());
        let values = [cell(one, 0), cell(one, 1), cell(&other, 1)];
        let [Some(time_s), Some(a), Some(b)] = values else {
            return Err(format!("`{one}` and `{other}` are no rows of a record").into());
        };
        text += &format!("{time_s},{:.4}\n", a + b);
    }
    Ok(text)
}

/// Files of the first view, as sorted paths relative to the site.
fn first_view(folder: &Path) -> Result<Vec<String>, Failure> {
    let mut names = Vec::new();
    collect(folder, "", &mut names)?;
    names.retain(|name| {
        let file = Path::new(name).file_name().and_then(OsStr::to_str).unwrap_or_default();
        !file.starts_with(FORMATS_MODULE) && file != "sw.js" && !file.starts_with("LICENSE")
    });
    names.sort();
    Ok(names)
}

fn collect(folder: &Path, before: &str, names: &mut Vec<String>) -> Result<(), Failure> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{before}{}", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() {
            collect(&entry.path(), &format!("{name}/"), names)?;
        } else {
            names.push(name);
        }
    }
    Ok(())
}

/// Writes the list of cached files into the service worker, under a cache name that changes with their content.
fn fill_service_worker(folder: &Path, names: &[String]) -> Result<(), Failure> {
    let mut hasher = DefaultHasher::new();
    for name in names {
        name.hash(&mut hasher);
        std::fs::read(folder.join(name))?.hash(&mut hasher);
    }
    let list: Vec<String> = std::iter::once("./".to_owned()).chain(names.iter().cloned()).collect();
    let path = folder.join("sw.js");
    let script = std::fs::read_to_string(&path)?;
    let filled = script
        .replace("__FINGERPRINT__", &format!("{:016x}", hasher.finish()))
        .replace("/*__FILES__*/ []", &format!("{list:?}"));
    std::fs::write(path, filled)?;
    Ok(())
}

/// Size of a file compressed by gzip; its plain size if gzip is missing.
fn gzipped(file: &Path) -> Result<u64, Failure> {
    let packed = command("gzip").args(["-9", "-c"]).arg(file).output();
    match packed {
        Ok(output) if output.status.success() => Ok(output.stdout.len() as u64),
        _ => Ok(std::fs::metadata(file)?.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_glue_is_of_the_version_of_its_program() {
        let version = |manifest: &str, package: &str| {
            let text = std::fs::read_to_string(root().join(manifest)).unwrap();
            let asked = format!("{package} = \"=");
            let line = text.lines().find_map(|line| line.strip_prefix(&asked).map(str::to_owned));
            line.unwrap_or_else(|| panic!("{manifest} names no exact {package}"))
        };
        let module = version("crates/slipfit-wasm/Cargo.toml", "wasm-bindgen");
        assert_eq!(module, version(GLUE, "wasm-bindgen-cli-support"));
    }

    #[test]
    fn records_of_the_same_instants_are_added() {
        let text = sum("# a\nt,x\n0,1\n0.5,2\n", "t,x\n0,0.25\n0.5,-2\n").unwrap();
        assert_eq!(text, "time (s),displacement (V)\n0,1.2500\n0.5,0.0000\n");
        assert!(sum("t,x\n0,one\n", "t,x\n0,1\n").is_err());
    }
}
