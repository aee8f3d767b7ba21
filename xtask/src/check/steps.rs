//! The steps of the check, quick ones first.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::outcome::{Outcome, Step};
use crate::places::{cargo, command, root, run, slipfit, slipfit_build, succeeds, target};
use crate::tools::{CARGO_DENY, TYPOS};
use crate::web::{self, Toolchain, WASM};
use crate::{Failure, book, python};

pub(super) const ALL: [Step; 14] = [
    Step::dev("format", format),
    Step::dev("core links no C", core_links_no_c),
    Step::dev("core without default features", core_without_default_features),
    Step::dev("libraries without a feature", libraries_without_a_feature),
    Step::dev("clippy", clippy),
    Step::dev("documentation", documentation),
    Step::dev("tests", tests),
    Step::dev("documentation tests", documentation_tests),
    Step::release("Python package", python_package),
    Step::release("commands of the documentation", commands_of_the_documentation),
    Step::release("page in a browser", page_in_a_browser),
    Step::release("licences, bans, sources", licences_bans_sources),
    Step::release("advisories", advisories),
    Step::release("spelling", spelling),
];

/// Built only by `cargo xtask fuzz`, because linking libFuzzer requires a C++ compiler.
const FUZZ: &str = "slipfit-fuzz";

fn format() -> Result<Outcome, Failure> {
    let output = cargo().args(["fmt", "--all", "--check"]).output()?;
    let said = [output.stdout, output.stderr].concat();
    eprint!("{}", String::from_utf8_lossy(&said));
    // cargo fmt reports success when rustfmt is killed, so its output is checked too.
    if output.status.success() && said.is_empty() {
        Ok(Outcome::passed())
    } else {
        Err("cargo fmt --all --check".into())
    }
}

/// All dependencies of the core, for the web and natively, are pure Rust.
fn core_links_no_c() -> Result<Outcome, Failure> {
    for selection in [&["--target", WASM, "--no-default-features"][..], &["--all-features"]] {
        let mut tree = cargo();
        tree.args(["tree", "--package", "slipfit", "--edges", "normal,build", "--prefix", "none"]);
        let output = tree.args(["--format", "{p}"]).args(selection).output()?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        }
        let text = String::from_utf8_lossy(&output.stdout);
        let names = text.lines().filter_map(|line| line.split_whitespace().next());
        if let Some(name) = names.into_iter().find(|name| brings_c(name)) {
            return Err(format!("the core depends on `{name}`, which builds or links C").into());
        }
    }
    Ok(Outcome::passed())
}

fn brings_c(package: &str) -> bool {
    const BUILDERS: [&str; 6] = ["bindgen", "cc", "cmake", "pkg-config", "system-deps", "vcpkg"];
    // These only declare system or browser interfaces; they compile no C code.
    const HARMLESS: [&str; 4] = ["js-sys", "linux-raw-sys", "web-sys", "windows-sys"];
    BUILDERS.contains(&package) || (package.ends_with("-sys") && !HARMLESS.contains(&package))
}

/// Only checked here; code is generated when the page is built.
fn core_without_default_features() -> Result<Outcome, Failure> {
    let alone = ["--package", "slipfit", "--lib", "--no-default-features"];
    run(cargo().arg("clippy").args(alone).args(["--", "-D", "warnings"]))?;
    Ok(Outcome::passed())
}

/// Checks that each library compiles without each of its default features, with the others on.
fn libraries_without_a_feature() -> Result<Outcome, Failure> {
    let mut builds = 0;
    for package in ["slipfit", "slipfit-io", "slipfit-report"] {
        let manifest = std::fs::read_to_string(root().join("crates").join(package).join("Cargo.toml"))?;
        let features = default_features(&manifest);
        for left_out in &features {
            let others: Vec<&str> = features.iter().copied().filter(|other| other != left_out).collect();
            let mut clippy = cargo();
            clippy.args(["clippy", "--package", package, "--lib", "--no-default-features", "--features"]);
            run(clippy.arg(others.join(",")).args(["--", "-D", "warnings"]))?;
            builds += 1;
        }
    }
    Ok(Outcome::Passed(format!("{builds} combinations")))
}

fn default_features(manifest: &str) -> Vec<&str> {
    let list = manifest.lines().find_map(|line| line.strip_prefix("default = ["));
    list.map_or_else(Vec::new, |list| list.split('"').skip(1).step_by(2).collect())
}

fn clippy() -> Result<Outcome, Failure> {
    let mut clippy = cargo();
    clippy.args(["clippy", "--workspace", "--all-targets", "--all-features", "--", "-D", "warnings"]);
    // Nothing is linked here, so libFuzzer need not be built.
    run(clippy.env("CUSTOM_LIBFUZZER_PATH", root()))?;
    Ok(Outcome::passed())
}

fn documentation() -> Result<Outcome, Failure> {
    let mut doc = cargo();
    doc.args(["doc", "--workspace", "--exclude", FUZZ, "--all-features", "--no-deps"])
        .env("RUSTDOCFLAGS", "-D warnings");
    run(&mut doc)?;
    Ok(Outcome::passed())
}

/// Targets for `cargo test`, the same as nextest uses; documentation tests are a separate step.
const TARGETS: [&str; 4] = ["--lib", "--bins", "--tests", "--examples"];
const TESTED: [&str; 4] = ["--workspace", "--exclude", FUZZ, "--all-features"];

fn tests() -> Result<Outcome, Failure> {
    let mut tests = cargo();
    if succeeds(cargo().args(["nextest", "--version"])) {
        tests.args(["nextest", "run"]);
    } else {
        tests.arg("test").args(TARGETS);
    }
    run(tests.args(TESTED).arg("--no-fail-fast"))?;
    let data = std::env::var_os("SLIPFIT_REAL_DATA").map_or_else(|| "../shared/data".into(), PathBuf::from);
    // A relative path is taken relative to the workspace, as in the tests.
    let data = root().join(data);
    if data.is_dir() {
        return Ok(Outcome::passed());
    }
    let (skipped, place) = (tests_of_measured_files()?, data.display());
    Ok(Outcome::Passed(format!("{skipped} tests skipped: no real data at {place}; set SLIPFIT_REAL_DATA")))
}

/// Number of tests that are ignored when there are no measured files: all of `tests/real_*.rs`.
fn tests_of_measured_files() -> Result<usize, Failure> {
    let mut list = cargo();
    list.args(["test", "--quiet"]).args(TESTED).args(["--test", "real_*"]);
    let output = list.args(["--", "--list", "--format", "terse", "--ignored"]).output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.lines().filter(|line| line.ends_with(": test")).count())
}

fn documentation_tests() -> Result<Outcome, Failure> {
    run(cargo().args([
        "test",
        "--workspace",
        "--exclude",
        FUZZ,
        "--all-features",
        "--doc",
        "--no-fail-fast",
    ]))?;
    Ok(Outcome::passed())
}

/// Builds the wheel, installs it into a separate environment and compares it with the command.
fn python_package() -> Result<Outcome, Failure> {
    let environment = target()?.join("venv-package");
    // Downloads run while the command is compiled.
    let (programs, slipfit) = in_parallel(|| python_of_the_package(&environment), slipfit);
    let slipfit = slipfit?;
    let programs = match programs {
        Ok(programs) => programs,
        Err(failure) => return Ok(Outcome::Skipped(format!("Python package NOT tested: {failure}"))),
    };
    let python = python::python_in(&programs);
    let wheels = target()?.join("wheels");
    if wheels.is_dir() {
        std::fs::remove_dir_all(&wheels)?;
    }
    // Both are built in release mode: the test profile would take several times as long.
    let mut maturin = command(programs.join("maturin"));
    maturin.args(["build", "--quiet", "--release", "--interpreter"]).arg(&python);
    run(maturin.arg("--out").arg(&wheels).env("CARGO", cargo().get_program()))?;
    let wheel = std::fs::read_dir(&wheels)?.next().ok_or("maturin built no wheel")??.path();
    let again = [OsStr::new("--force-reinstall"), OsStr::new("--no-deps"), wheel.as_os_str()];
    python::install(&programs, again)?;
    let mut tests = command(&python);
    tests.args(["-m", "pytest", "--quiet", "--numprocesses", "auto", "--dist", "worksteal"]);
    run(tests.env("SLIPFIT_COMMAND", slipfit))?;
    // Type checks; the second checker's Node program is downloaded the first time.
    let types = || {
        run(command(&python).args(["-m", "mypy"]))?;
        run(command(programs.join("pyright")).arg("--pythonpath").arg(&python))
    };
    // Compares the stub of the extension with the extension.
    let stub = || {
        let options = ["slipfit._core", "--mypy-config-file", "pyproject.toml"];
        run(command(&python).args(["-m", "mypy.stubtest"]).args(options))
    };
    let (types, stub) = in_parallel(|| types().map_err(|failure| failure.to_string()), stub);
    types?;
    stub?;
    Ok(Outcome::passed())
}

/// An environment with the requirements of the package and its tests.
fn python_of_the_package(environment: &Path) -> Result<PathBuf, String> {
    let requirements = root().join("crates/slipfit-py/tests/requirements.txt");
    let made = python::environment(environment).and_then(|programs| {
        python::install(&programs, [OsStr::new("--requirement"), requirements.as_os_str()])?;
        Ok(programs)
    });
    made.map_err(|failure| failure.to_string())
}

/// Runs one task while another runs.
fn in_parallel<A: Send, B>(one: impl FnOnce() -> A + Send, other: impl FnOnce() -> B) -> (A, B) {
    std::thread::scope(|scope| {
        let one = scope.spawn(one);
        let other = other();
        match one.join() {
            Ok(one) => (one, other),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

fn commands_of_the_documentation() -> Result<Outcome, Failure> {
    if !succeeds(command("sh").args(["-c", "true"])) {
        return Ok(Outcome::Skipped("commands NOT run: there is no `sh`".into()));
    }
    let found = book::check(false)?;
    for difference in &found.differ {
        eprintln!("\n{difference}");
    }
    match found.differ.len() {
        0 => Ok(Outcome::Passed(format!("{} commands on {} pages", found.commands, found.pages))),
        n => {
            Err(format!("{n} commands print something else; cargo xtask book --write renews the pages")
                .into())
        }
    }
}

/// Builds the site, checks its scripts, and tests it in Chromium against the command. Missing tools are reported in
/// the table: without the target, neither the page nor the web build of the core is built.
fn page_in_a_browser() -> Result<Outcome, Failure> {
    let toolchain = match Toolchain::find() {
        Ok(toolchain) => toolchain,
        Err(missing) => {
            return Ok(Outcome::Skipped(format!("page and core NOT built for the web: {missing}")));
        }
    };
    let folder = root().join("web");
    let packages = || {
        let mut npm = command("npm");
        npm.args(["ci", "--no-audit", "--no-fund", "--prefix"]).arg(&folder);
        succeeds(&mut npm)
    };
    let (packages, site) = in_parallel(packages, || web::build(&toolchain));
    let site = site?;
    let size = format!("{} kB packed at the first view", site.packed / 1000);
    if site.packed > web::MOST_PACKED {
        return Err(format!("{size}: {} kB at most", web::MOST_PACKED / 1000).into());
    }
    let skipped = |reason: &str| Ok(Outcome::Skipped(format!("page built, {size}, NOT tested: {reason}")));
    if !packages {
        return skipped("`npm ci` in web/ cannot be run");
    }
    run(command("node")
        .arg("node_modules/typescript/bin/tsc")
        .args(["--project", "."])
        .current_dir(&folder))?;
    let Some(browser) = web::chromium() else { return skipped("there is no Chromium; CHROMIUM names one") };
    // The page must agree with the command, which also serves it.
    run(slipfit_build().env("SLIPFIT_SITE", &site.folder))?;
    let mut tests = command("node");
    tests.args(["--test", "--test-concurrency=2", "tests/"]).current_dir(&folder);
    run(tests.env("SLIPFIT_SITE", &site.folder).env("CHROMIUM", browser))?;
    Ok(Outcome::Passed(size))
}

fn licences_bans_sources() -> Result<Outcome, Failure> {
    run(command(CARGO_DENY.program()?).args(["check", "licenses", "bans", "sources"]))?;
    Ok(Outcome::passed())
}

/// Checks for known vulnerabilities. The list is on the network: without network access, and without a copy fetched
/// earlier, the step is skipped and reported as such. `SLIPFIT_ADVISORIES` names a reachable copy, a git repository
/// given by address or folder.
fn advisories() -> Result<Outcome, Failure> {
    let deny = CARGO_DENY.program()?;
    if let Some(copy) = std::env::var_os("SLIPFIT_ADVISORIES") {
        return advisories_of(&deny, &copy.to_string_lossy());
    }
    let ask = |flags: &[&str]| -> Result<(bool, String), Failure> {
        let mut check = command(&deny);
        // A request for a password would wait forever.
        check.args(flags).args(["check", "advisories"]).env("GIT_TERMINAL_PROMPT", "0");
        let output = check.output()?;
        let said = [output.stdout, output.stderr].concat();
        Ok((output.status.success(), String::from_utf8_lossy(&said).into_owned()))
    };
    let (passed, said) = ask(&[])?;
    eprint!("{said}");
    if passed {
        return Ok(Outcome::passed());
    }
    if !said.contains("failed to fetch advisory database") {
        return Err("cargo-deny check advisories".into());
    }
    let (passed, said) = ask(&["--offline"])?;
    eprint!("{said}");
    if passed {
        return Ok(Outcome::Passed("against the copy fetched earlier: the list is out of reach".into()));
    }
    // A finding appears as a diagnostic; any other failure means that the copy is missing or too old.
    if said.contains("error[") {
        return Err("cargo-deny check advisories, against the copy fetched earlier".into());
    }
    Ok(Outcome::Skipped("vulnerabilities NOT checked: the advisory list is out of reach".into()))
}

/// Checks against this copy of the list.
fn advisories_of(deny: &Path, copy: &str) -> Result<Outcome, Failure> {
    let address = if Path::new(copy).is_dir() {
        format!("file://{}", std::fs::canonicalize(copy)?.display())
    } else {
        copy.to_owned()
    };
    let settings = std::fs::read_to_string(root().join("deny.toml"))?;
    let config = target()?.join("deny.toml");
    std::fs::write(&config, with_list(&settings, &address)?)?;
    run(command(deny).args(["check", "--config"]).arg(&config).arg("advisories"))?;
    Ok(Outcome::Passed(format!("against {copy}")))
}

/// The settings of cargo-deny with a different location of the list.
fn with_list(settings: &str, address: &str) -> Result<String, Failure> {
    let heading = "[advisories]\n";
    let (before, after) = settings.split_once(heading).ok_or("deny.toml has no [advisories]")?;
    Ok(format!("{before}{heading}db-urls = [{address:?}]\n{after}"))
}

fn spelling() -> Result<Outcome, Failure> {
    run(&mut command(TYPOS.program()?))?;
    Ok(Outcome::passed())
}

#[cfg(test)]
mod tests {
    use super::{brings_c, default_features, with_list};

    #[test]
    fn crates_that_compile_or_link_c_are_told_from_those_that_only_look_so() {
        for package in ["cc", "cmake", "openblas-sys", "hdf5-sys"] {
            assert!(brings_c(package), "{package}");
        }
        for package in ["nalgebra", "windows-sys", "linux-raw-sys", "web-sys", "accelerate"] {
            assert!(!brings_c(package), "{package}");
        }
    }

    #[test]
    fn the_list_of_vulnerabilities_may_lie_elsewhere() {
        let settings = "[bans]\nwildcards = 1\n\n[advisories]\nyanked = \"deny\"\n";
        let with = with_list(settings, "file:///copy").unwrap();
        assert!(with.ends_with("[advisories]\ndb-urls = [\"file:///copy\"]\nyanked = \"deny\"\n"), "{with}");
        assert!(with_list("[bans]\n", "file:///copy").is_err());
    }

    #[test]
    fn default_features_are_read_from_a_manifest() {
        let manifest = "[features]\ndefault = [\"arrow\", \"excel\"]\narrow = [\"dep:arrow\"]\n";
        assert_eq!(default_features(manifest), ["arrow", "excel"]);
        assert!(default_features("[dependencies]\n").is_empty());
    }
}
