//! The results as a table, as JSON and as CSV.

use super::contest::{Contest, Outcome};
use super::division::{self, Divided};
use serde_json::{Value, json};
use std::fmt::Write;

/// The results of a scene as a table.
pub fn table(contest: &Contest) -> String {
    let (width, height) = contest.scene.size;
    let mut text = format!("{}, {width} × {height}; {}\n", contest.scene.name, contest.driver);
    let heads =
        ["time", "quartiles", "processor", "ms", "texels", "max px", "99.9 %", "rms", "max ′", "wrong", "dB", "SSIM"];
    let [time, quartiles, processor, ms, texels, max, most, rms, minutes, wrong, psnr, ssim] = heads;
    // Writing into a string cannot fail.
    let _ = writeln!(
        text,
        "  {:58}{time:>6}{quartiles:>12}{processor:>10}{ms:>8}{texels:>8}{max:>11}{most:>11}{rms:>11}{minutes:>9}{wrong:>8}{psnr:>7}{ssim:>8}",
        ""
    );
    for result in &contest.results {
        let name = if result.is_default { format!("* {}", result.name) } else { format!("  {}", result.name) };
        let quartiles = format!("{:.2}–{:.2}", result.spread.0, result.spread.1);
        let texels = result.texels.map_or(String::new(), |texels| format!("{texels:.2}"));
        let _ = write!(
            text,
            "{name:60}{:6.2}{quartiles:>12}{:10.2}{:8.2}{texels:>8}",
            result.ratio, result.processor_ratio, result.milliseconds
        );
        if let Some(error) = &result.error {
            let wrong = error.map.uncovered + error.map.ghosts + error.map.non_finite;
            let _ = write!(
                text,
                "{:>11}{:>11}{:>11}{:>9}{wrong:>8}",
                short(error.map.max),
                short(error.most),
                short(error.map.rms),
                short(error.minutes)
            );
        }
        if let Some(quality) = &result.quality {
            let _ = write!(text, "{:7.2}{:8.4}", quality.psnr, quality.ssim);
        }
        text.push('\n');
    }
    text.push('\n');
    text
}

/// A number with four decimal places, or in scientific notation.
fn short(value: f64) -> String {
    if value == 0.0 || (0.001..1000.0).contains(&value) { format!("{value:.4}") } else { format!("{value:.1e}") }
}

/// The results as JSON.
pub fn json(contests: &[Contest], divided: Option<&Divided>) -> Value {
    let result = |result: &Outcome| {
        let error = result.error.as_ref().map(|error| {
            json!({
                "max": error.map.max,
                "most": error.most,
                "rms": error.map.rms,
                "max_minutes_of_arc": error.minutes,
                "uncovered": error.map.uncovered,
                "ghosts": error.map.ghosts,
                "non_finite": error.map.non_finite,
            })
        });
        json!({
            "method": result.name,
            "default": result.is_default,
            "time_ratio": result.ratio,
            "time_ratio_quartiles": [result.spread.0, result.spread.1],
            "processor_time_ratio": result.processor_ratio,
            "milliseconds": result.milliseconds,
            "view_texels_per_pixel": result.texels,
            "error_pixels": error,
            "psnr": result.quality.map(|quality| quality.psnr),
            "ssim": result.quality.map(|quality| quality.ssim),
        })
    };
    let contest = |contest: &Contest| {
        json!({
            "scene": contest.scene.name,
            "size": [contest.scene.size.0, contest.scene.size.1],
            "driver": contest.driver,
            "results": contest.results.iter().map(result).collect::<Vec<_>>(),
        })
    };
    json!({
        "contests": contests.iter().map(contest).collect::<Vec<_>>(),
        "division": divided.map(division::as_json),
    })
}

/// The results as CSV.
pub fn csv(contests: &[Contest]) -> String {
    let mut text = String::from(
        "scene,width,height,method,default,time_ratio,time_ratio_low,time_ratio_high,processor_ratio,milliseconds,\
         view_texels_per_pixel,error_max,error_most,error_rms,error_minutes,uncovered,ghosts,non_finite,psnr,ssim\n",
    );
    for contest in contests {
        for result in &contest.results {
            let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            let error = |of: &dyn Fn(&super::contest::Errors) -> f64| number(result.error.as_ref().map(of));
            let cells = [
                quoted(contest.scene.name),
                contest.scene.size.0.to_string(),
                contest.scene.size.1.to_string(),
                quoted(&result.name),
                result.is_default.to_string(),
                result.ratio.to_string(),
                result.spread.0.to_string(),
                result.spread.1.to_string(),
                result.processor_ratio.to_string(),
                result.milliseconds.to_string(),
                number(result.texels),
                error(&|error| error.map.max),
                error(&|error| error.most),
                error(&|error| error.map.rms),
                error(&|error| error.minutes),
                error(&|error| error.map.uncovered as f64),
                error(&|error| error.map.ghosts as f64),
                error(&|error| error.map.non_finite as f64),
                number(result.quality.map(|quality| quality.psnr)),
                number(result.quality.map(|quality| quality.ssim)),
            ];
            text.push_str(&cells.join(","));
            text.push('\n');
        }
    }
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
