//! `slipfit-glue MODULE NAME FOLDER`: does what `wasm-bindgen --target web --no-typescript` does.

use std::process::ExitCode;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [module, name, folder] = words.as_slice() else {
        eprintln!("slipfit-glue takes a module, the name of what is written, and a folder");
        return ExitCode::from(2);
    };
    let written = || {
        let mut glue = Bindgen::new();
        glue.input_path(module).web(true)?.typescript(false).remove_name_section(true).remove_producers_section(true);
        glue.omit_default_module_path(false).out_name(name).generate(folder)
    };
    match written() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {module}: {error:?}");
            ExitCode::from(2)
        }
    }
}
