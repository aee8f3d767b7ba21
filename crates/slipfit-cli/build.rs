//! Embeds the commit of the build, if it can be found without a network, and the page of `slipfit app`.

use std::path::Path;
#[cfg(feature = "app")]
use std::path::PathBuf;
use std::process::Command;

/// Path of this crate in its own repository. A copy inside another repository, such as a vendored one, must not
/// report the commit of that repository.
const PLACE: &str = "crates/slipfit-cli/";

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    #[cfg(feature = "app")]
    pack_site();
    if let Some(commit) = packaged().or_else(checked_out) {
        println!("cargo:rustc-env=SLIPFIT_COMMIT={commit}");
    }
}

/// The commit from the file that `cargo package` puts next to the manifest.
fn packaged() -> Option<String> {
    let note = Path::new(&std::env::var_os("CARGO_MANIFEST_DIR")?).join(".cargo_vcs_info.json");
    // Named only if it exists: a missing file would make every build run this again.
    let text = std::fs::read_to_string(&note).ok()?;
    println!("cargo:rerun-if-changed={}", note.display());
    let after = text.split_once("\"sha1\"")?.1;
    short(after.split('"').nth(1)?)
}

/// The commit from the repository around this crate.
fn checked_out() -> Option<String> {
    if git(&["rev-parse", "--show-prefix"])? != PLACE {
        return None;
    }
    // The log of HEAD grows with every commit, checkout and reset. If it is switched off, HEAD and the branches
    // change instead.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"]);
    let watched: &[&str] = match log.filter(|log| Path::new(log).is_file()) {
        Some(_) => &["HEAD", "logs/HEAD"],
        None => &["HEAD", "refs/heads", "packed-refs"],
    };
    for name in watched {
        if let Some(path) = git(&["rev-parse", "--git-path", name]).filter(|path| Path::new(path).exists()) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    short(&git(&["rev-parse", "HEAD"])?)
}

fn short(commit: &str) -> Option<String> {
    (commit.len() >= 12 && commit.bytes().all(|b| b.is_ascii_hexdigit())).then(|| commit[..12].to_owned())
}

/// A word of git's output, run in this crate's folder; `None` if git or a repository is missing.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| said.trim().to_owned())
}

/// Writes `SITE`, the packed files of the folder that `SLIPFIT_SITE` names; empty if it is not set.
#[cfg(feature = "app")]
fn pack_site() {
    println!("cargo:rerun-if-env-changed=SLIPFIT_SITE");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo names a folder to write to"));
    let mut assets = String::new();
    if let Some(folder) = std::env::var_os("SLIPFIT_SITE").map(PathBuf::from) {
        println!("cargo:rerun-if-changed={}", folder.display());
        let page = folder.join("index.html");
        assert!(page.is_file(), "SLIPFIT_SITE: {} is missing; `cargo xtask web` builds it", page.display());
        let mut files = Vec::new();
        collect(&folder, "", &mut files);
        files.sort();
        for (i, name) in files.iter().enumerate() {
            let packed = out.join(format!("site-{i}.gz"));
            std::fs::write(&packed, pack(&folder, name)).expect("the page is packed beside the program");
            assets += &format!("    Asset {{ path: {name:?}, packed: include_bytes!({packed:?}) }},\n");
        }
    }
    let text = format!("pub(super) const SITE: &[Asset] = &[\n{assets}];\n");
    std::fs::write(out.join("site.rs"), text).expect("the list of the page's files is written");
}

/// Paths below a folder, except the service worker that caches the page: this server exists only for one run.
#[cfg(feature = "app")]
fn collect(folder: &Path, before: &str, files: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("the page can be read").flatten() {
        let name = format!("{before}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{name}/"), files);
        } else if name != "sw.js" {
            files.push(name);
        }
    }
}

/// A file of the page, compressed by gzip; the page itself is marked as served by this program.
#[cfg(feature = "app")]
fn pack(folder: &Path, name: &str) -> Vec<u8> {
    use std::io::Write as _;
    let mut bytes = std::fs::read(folder.join(name)).expect("the page can be read");
    if name == "index.html" {
        let page = String::from_utf8(bytes).expect("the page is text");
        let (plain, served) = ("<html lang=\"en\">", "<html lang=\"en\" data-app=\"yes\">");
        assert!(page.contains(plain), "SLIPFIT_SITE: index.html begins with another element than {plain}");
        bytes = page.replacen(plain, served, 1).into_bytes();
    }
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(&bytes).expect("bytes are packed in memory");
    packer.finish().expect("bytes are packed in memory")
}
