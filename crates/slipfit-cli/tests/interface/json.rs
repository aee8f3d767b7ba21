//! Real answers follow the contract.

use crate::common::{example, keeps_to_schema, schema, slipfit, stdout};
use serde_json::Value;

fn answer(file: &str, more: &[&str]) -> Value {
    let text = stdout(slipfit().arg("ringdown").arg(example(file)).args(["--json", "-"]).args(more));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{file}: {e}\n{text}"))
}

fn answers() -> Vec<Value> {
    vec![
        answer("classroom_pendulum.csv", &[]),
        answer("classroom_pendulum.csv", &["--inertia", "0.05±0.001", "--start", "1", "--end", "20"]),
        // Without viscous damping the quality factor is infinite.
        answer("classroom_pendulum.csv", &["--model", "sliding", "--band", "0.5", "1.2"]),
        answer("tuning_fork_9nN.csv", &["--stiffness", "10000(200)"]),
        answer("tuning_fork_9nN.csv", &["--lockin-time-constant", "20e-6", "--lockin-order", "2"]),
        answer("tuning_fork_9nN_waveform.csv", &["--mass", "2.369e-7"]),
    ]
}

#[test]
fn answers_keep_to_the_schema() {
    for answer in answers() {
        keeps_to_schema(&answer, "ringdown");
    }
}

#[test]
fn the_schema_is_able_to_refuse() {
    let validator = jsonschema::draft202012::new(&schema("ringdown")).unwrap();
    let mut answer = answer("classroom_pendulum.csv", &[]);
    assert!(validator.is_valid(&answer));
    answer["sliding"]["detected"] = Value::from("yes");
    assert!(!validator.is_valid(&answer));
    answer["sliding"].as_object_mut().unwrap().remove("detected");
    assert!(!validator.is_valid(&answer));
}

/// All options are included in the answer.
#[test]
fn every_option_is_echoed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let decay = "simulate decay --frequency-hz 100 --q 60 --friction-displacement 0.002 --amplitude 0.3 \
                 --duration 2 --rate-hz 400 --noise-rms 1e-3 --output envelope --out";
    stdout(slipfit().args(decay.split_whitespace()).arg(at("decay.csv")));
    let [decay, sweep, levels] = [
        ("ringdown --start 0.01 --end 1 --min-amplitude 0.01 --band 0.001 150 --model viscous+sliding --law free \
          --lockin-time-constant 1e-4 --lockin-order 2 --frequency-hz 100 --stiffness 3", at("decay.csv")),
        ("resonance --drive-amplitude 10e-12 --response leading --model viscous+sliding --band 32000 33500 \
          --background on --delay on --amplitude-offset off --noise-floor off --phase-offset on --duffing on --stiffness 3",
         example("tuning_fork_9nN_sweep.csv").display().to_string()),
        ("levels --frequency-hz 100 --drive-gain 3 --stiffness 3",
         example("tuning_fork_9nN_levels.csv").display().to_string()),
    ]
    .map(|(line, file)| {
        let text = stdout(slipfit().args(line.split_whitespace()).arg(file).args(["--json", "-"]));
        let answer: Value = serde_json::from_str(&text).unwrap();
        answer["options"].as_object().unwrap().clone()
    });
    for options in [decay, sweep] {
        let left_out: Vec<_> = options.iter().filter(|(_, value)| value.is_null()).collect();
        assert!(left_out.is_empty(), "{left_out:?}");
    }
    let left_out: Vec<_> = levels.iter().filter(|(_, value)| value.is_null()).map(|(key, _)| key).collect();
    assert_eq!(left_out, ["q_factor"], "which --drive-gain excludes");
}

#[test]
fn an_infinite_quality_factor_is_null() {
    let answer = answer("classroom_pendulum.csv", &["--model", "sliding"]);
    assert_eq!(answer["model"], "sliding");
    assert_eq!(answer["parameters"]["q_factor"]["value"], Value::Null);
    assert_eq!(answer["parameters"]["decay_rate_per_s"]["value"], 0.0);
}

#[test]
fn calibrated_answers_give_forces_near_the_truth() {
    let answer = answer("tuning_fork_9nN_waveform.csv", &["--stiffness", "10000±200"]);
    let force = &answer["parameters"]["coulomb_force"];
    assert_eq!(force["unit"], "N");
    let (value, error) = (force["value"].as_f64().unwrap(), force["std_error"].as_f64().unwrap());
    // Five standard errors: the seed is fixed, and the test is that the units are right.
    assert!((value - 15e-9).abs() < 5.0 * error, "{force}");
    assert!(error < 1e-9, "{force}");
    // The uncertainty includes the two per cent of the stiffness.
    assert!(error > 0.02 * 15e-9, "{force}");
}

#[test]
fn the_hash_is_that_of_the_file() {
    use sha2::{Digest, Sha256};
    let digest = Sha256::digest(std::fs::read(example("classroom_pendulum.csv")).unwrap());
    let hex: String = digest.iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(answer("classroom_pendulum.csv", &[])["input"]["sha256"], hex);
}

/// A term that no analysis compares by default takes part if a model names it.
#[test]
fn a_term_is_compared_where_the_model_asked_for_has_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nonlinear.csv");
    // Amplitudes under dA/dt = -(delta A + a3 A³): 1/A² + a3/delta grows as e^(2 delta t).
    let (delta, a3) = (0.01f64, 0.12f64);
    let mut text = String::from("time (s),angle (rad)\n");
    for i in 0..4000u32 {
        let t = 0.05 * f64::from(i);
        let growth = (2.0 * delta * t).exp();
        let amplitude = (growth / 0.25 + a3 / delta * (growth - 1.0)).sqrt().recip();
        let noise = 1e-3 * (7.7 * f64::from(i) * f64::from(i)).sin();
        text += &format!("{t:.3},{:.7}\n", amplitude * (6.0 * t).cos() + noise);
    }
    std::fs::write(&path, text).unwrap();
    let json = |more: &[&str]| -> Value {
        let text = stdout(slipfit().arg("ringdown").arg(&path).args(["--json", "-"]).args(more));
        serde_json::from_str(&text).unwrap()
    };
    let answer = json(&["--model", "viscous+cubic"]);
    assert_eq!(answer["model"], "viscous+cubic");
    let found = &answer["parameters"]["cubic_rate"];
    assert!((found["value"].as_f64().unwrap() / a3 - 1.0).abs() < 0.05, "{found}");
    assert_eq!(found["unit"], "1/(rad² s)");
    assert_eq!(answer["comparison"].as_array().unwrap().len(), 15);
    let validator = jsonschema::draft202012::new(&schema("ringdown")).unwrap();
    let errors: Vec<String> = validator.iter_errors(&answer).map(|e| e.to_string()).collect();
    assert!(errors.is_empty(), "{errors:#?}");
    // If it is not asked for, it does not appear.
    assert!(!json(&[]).to_string().contains("cubic"));
    // The table, the equations and the sentence include it.
    let page = folder.path().join("page.md");
    let report =
        stdout(slipfit().arg("ringdown").arg(&path).args(["--model", "viscous+cubic", "--md"]).arg(&page));
    assert!(report.contains("\n  cubic damping rate      a₃"), "{report}");
    assert!(report.starts_with("Viscous damping and cubic damping explain the decay"), "{report}");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("| *a*<sub>3</sub> [1/(rad² s)] |"), "{page}");
}
