//! Contents of figures: a finding in the title, marks, the number of methods, and the page size.

use crate::common::{Folder, METHODS, experiment, number, of_method};

fn scene(name: &str) -> String {
    experiment(name).display().to_string()
}

/// The words of an SVG file.
fn words(folder: &Folder, name: &str) -> Vec<String> {
    let text = folder.read(name);
    let document = roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
    let words = document.descendants().filter(|node| node.is_text());
    let words = words.filter_map(|node| node.text());
    words.map(str::to_owned).collect()
}

/// Returns the number of occurrences of a text element.
fn count(words: &[String], what: &str) -> usize {
    words.iter().filter(|word| *word == what).count()
}

/// Returns the words of a title, joined across its lines.
fn title(words: &[String]) -> String {
    words.join(" ")
}

#[test]
fn figure_title_states_the_errors_of_the_report() {
    let folder = Folder::new();
    let arguments = format!(
        "simulate {} --method basic,hfcr,coupled --plot few.svg",
        scene("fig2")
    );
    let report = folder.json(&arguments);
    let error = |method: &str| number(of_method(&report, method), "force_rendering_error_percent");
    let shown = title(&words(&folder, "few.svg"));
    let expected = format!(
        "Nearest to the ideal: coupled, FRE {:.1} % (hold bound {:.1} %); farthest: basic, {:.1} %",
        error("coupled"),
        number(&report, "hold_bound_percent"),
        error("basic")
    );
    assert!(shown.contains(&expected), "{shown}");
    // Another scene has another finding.
    let report = folder.json(&format!(
        "simulate {} --method basic,hfcr,coupled --plot other.svg",
        scene("experiment1")
    ));
    let shown = title(&words(&folder, "other.svg"));
    assert!(!shown.contains(&expected));
    let coupled = number(
        of_method(&report, "coupled"),
        "force_rendering_error_percent",
    );
    assert!(
        shown.contains(&format!("coupled, FRE {coupled:.1} %")),
        "{shown}"
    );
}

#[test]
fn the_farthest_is_one_of_those_that_hold_together() {
    let folder = Folder::new();
    let report = folder.json(&format!(
        "simulate {} --method all --plot all.svg",
        scene("experiment2")
    ));
    let error = |method: &str| number(of_method(&report, method), "force_rendering_error_percent");
    assert!(
        error("hfcr-mod") > error("popc"),
        "or there is nothing to say"
    );
    let shown = words(&folder, "all.svg");
    let expected = format!(
        "; diverged or stopped: 5 of 14; farthest of the others: popc, {:.1} %",
        error("popc")
    );
    assert!(title(&shown).contains(&expected), "{shown:?}");
    let head = format!("hfcr-mod: FRE {:.1} %, diverged", error("hfcr-mod"));
    assert_eq!(count(&shown, &head), 1, "{shown:?}");
}

#[test]
fn where_no_loop_runs_away_every_leak_is_on_the_scale() {
    let folder = Folder::new();
    folder.succeed(&format!(
        "simulate {} --method basic,coupled --plot two.svg",
        scene("fig2")
    ));
    let shown = title(&words(&folder, "two.svg"));
    assert!(!shown.contains("off scale: basic"), "{shown}");
}

#[test]
fn one_run_says_its_own_error_and_leak() {
    let folder = Folder::new();
    let report = folder.json(&format!(
        "simulate {} --method hfcr --plot one.svg",
        scene("fig2")
    ));
    let hfcr = of_method(&report, "hfcr");
    let shown = title(&words(&folder, "one.svg"));
    let expected = format!(
        "hfcr: FRE {:.1} % (hold bound {:.1} %), leaks of {:.1} mJ",
        number(hfcr, "force_rendering_error_percent"),
        number(&report, "hold_bound_percent"),
        1e3 * number(hfcr, "absolute_leak_held_j")
    );
    assert!(shown.contains(&expected), "{shown}");
}

#[test]
fn few_methods_share_a_panel_and_many_have_one_each() {
    let folder = Folder::new();
    let fig2 = scene("fig2");
    folder.succeed(&format!(
        "simulate {fig2} --method basic,virtual-damper,hfcr,coupled --plot four.svg"
    ));
    let four = words(&folder, "four.svg");
    assert_eq!(count(&four, "position [mm]"), 1);
    for method in ["basic", "virtual-damper", "hfcr", "coupled"] {
        assert_eq!(count(&four, method), 1, "{method}");
    }
    assert!(explains_the_devices(&four));
    folder.succeed(&format!("simulate {fig2} --method all --plot all.svg"));
    let all = words(&folder, "all.svg");
    for method in METHODS {
        let head = format!("{method}: FRE ");
        let heads = all.iter().filter(|word| word.starts_with(&head)).count();
        assert_eq!(heads, 1, "{method}");
        assert_eq!(
            count(&all, method),
            0,
            "{method} has no entry in the legend"
        );
    }
    for name in ["ideal", "ideal device", "device", "rendered"] {
        assert_eq!(count(&all, name), 1, "{name} stands in the legend");
    }
}

#[test]
fn every_grey_line_and_the_device_have_a_name() {
    let folder = Folder::new();
    folder.write(
        "tap.csv",
        crate::common::trace_text(&crate::common::taps(0.001, 1.0)),
    );
    let render = "render tap.csv --stiffness 300 --mass 0.2 --period 0.01 --device-mass 0.2";
    folder.succeed(&format!(
        "{render} --method basic,coupled --plot motion.svg"
    ));
    let motion = words(&folder, "motion.svg");
    assert_eq!(count(&motion, "ideal"), 1);
    assert_eq!(count(&motion, "device, as recorded"), 1);
    assert_eq!(
        count(&motion, "ideal device"),
        0,
        "it moves as the recorded one"
    );
    folder.succeed(&format!(
        "{render} --method basic,coupled --replay hand --plot hand.svg"
    ));
    let hand = words(&folder, "hand.svg");
    for name in ["ideal", "ideal device"] {
        assert_eq!(count(&hand, name), 1, "{name}");
    }
    assert!(explains_the_devices(&hand));
}

/// Whether the small print says what the thin lines are, which have the colours of their methods.
fn explains_the_devices(words: &[String]) -> bool {
    let small_print = "Thin lines: the device under each method.";
    words.iter().any(|line| line.contains(small_print))
}

#[test]
fn the_chosen_damping_is_marked_where_the_report_says() {
    let folder = Folder::new();
    let report = folder.json(&format!(
        "tune {} --method virtual-damper --to 2 --steps 101 --plot tune.svg",
        scene("fig2")
    ));
    let best = &report["best"];
    let value = number(best, "value_n_s_per_m");
    let error = &best["mean_force_error_percent"];
    let shown = words(&folder, "tune.svg");
    let marked = format!("chosen: {value:.3} N s/m");
    assert_eq!(count(&shown, &marked), 1, "{shown:?}");
    let finding = format!(
        "has the least error: E {:.1} % in the median, {:.1} % at the worst height",
        number(error, "median"),
        number(error, "worst")
    );
    assert!(title(&shown).contains(&finding), "{shown:?}");
    // A ring in each panel, above the chosen value of the axis from 0 to 2.
    let text = folder.read("tune.svg");
    let document = roxmltree::Document::parse(&text).unwrap();
    let rings: Vec<f64> = (document.descendants())
        .filter(|node| node.attribute("stroke-width") == Some("1.6"))
        .filter_map(|node| node.attribute("cx")?.parse().ok())
        .collect();
    assert_eq!(rings.len(), 2, "{rings:?}");
    let frame = (document.descendants())
        .find(|node| node.has_tag_name("clipPath"))
        .and_then(|clip| clip.first_element_child())
        .unwrap();
    let side = |name: &str| frame.attribute(name).unwrap().parse::<f64>().unwrap();
    let expected = side("x") + side("width") * value / 2.0;
    for ring in rings {
        assert!((ring - expected).abs() < 0.5, "{ring} is not {expected}");
    }
}

#[test]
fn a_map_shows_four_methods_unless_others_are_named() {
    let folder = Folder::new();
    folder.succeed("map --cells 3 --threads 1");
    let shown = words(&folder, "map.svg");
    let columns = |shown: &[String]| -> Vec<&str> {
        let is_shown = |method: &&str| count(shown, method) > 0;
        METHODS.into_iter().filter(is_shown).collect()
    };
    assert_eq!(
        columns(&shown),
        ["basic", "virtual-damper", "hfcr", "coupled"]
    );
    assert!(title(&shown).contains("Stable bounces, share of the damped map: coupled "));
    let merge = "map merge map.csv --plot";
    folder.succeed(&format!("{merge} all.svg --method all"));
    assert_eq!(columns(&words(&folder, "all.svg")), METHODS);
    folder.succeed(&format!("{merge} two.svg --method popc,seh"));
    assert_eq!(columns(&words(&folder, "two.svg")), ["seh", "popc"]);
    folder.succeed("map --cells 3 --threads 1 --method seh,popc --out few.csv");
    assert_eq!(columns(&words(&folder, "few.svg")), ["seh", "popc"]);
    folder.fail(
        "map merge few.csv --plot none.svg --method hfcr",
        3,
        &["--method hfcr", "is not in the map, which has seh, popc"],
    );
}

#[test]
fn compared_scenes_are_panels_with_the_hold_floor() {
    let folder = Folder::new();
    let scenes = format!("{} {}", scene("fig2"), scene("experiment2"));
    let report = folder.json(&format!("compare {scenes} --plot dots.svg"));
    assert_eq!(report["files"], serde_json::json!(["dots.svg"]));
    let shown = words(&folder, "dots.svg");
    assert_eq!(count(&shown, "hold bound"), 1);
    assert_eq!(
        count(&shown, "FRE [%]"),
        2,
        "an axis for each of two panels"
    );
    assert!(title(&shown).contains("coupled has the least force error on 2 of 2 scenes"));
    // A dot for each method of each scene, besides the ring of the legend, if there is one.
    let text = folder.read("dots.svg");
    let document = roxmltree::Document::parse(&text).unwrap();
    let dots = (document.descendants())
        .filter(|node| node.has_tag_name("circle"))
        .count();
    let legend = count(&shown, "diverged, left the safety box or jammed");
    assert_eq!(dots, 2 * METHODS.len() + legend);
}

#[test]
fn an_advice_is_drawn_with_what_is_asked_for() {
    let folder = Folder::new();
    let advise = "advise --device-mass 0.3 --period 0.01 --stiffness 80 --mass 0.05";
    let report = folder.json(&format!("{advise} --method hfcr,coupled --plot reach.svg"));
    assert_eq!(report["files"], serde_json::json!(["reach.svg"]));
    assert_eq!(report["verdict"]["answer"], "yes");
    let shown = words(&folder, "reach.svg");
    let asked = "80 N/m for an object of 0.05 kg";
    assert_eq!(
        count(&shown, &format!("requested: {asked}")),
        1,
        "{shown:?}"
    );
    let method = report["verdict"]["method"].as_str().unwrap();
    assert!(title(&shown).contains(&format!("{asked}: yes, by {method}")));
    for axis in ["object mass M [kg]", "stiffness K [N/m]"] {
        assert!(count(&shown, axis) > 0, "{axis}");
    }
}

#[test]
fn a_figure_has_the_size_and_the_time_that_are_asked_for() {
    let folder = Folder::new();
    let simulate = format!("simulate {} --method hfcr", scene("fig2"));
    let size = |name: &str| {
        let text = folder.read(name);
        let document = roxmltree::Document::parse(&text).unwrap();
        let side = |side: &str| -> f64 {
            let side = document.root_element().attribute(side).unwrap();
            side.parse().unwrap()
        };
        (side("width") * 25.4 / 96.0, side("height") * 25.4 / 96.0)
    };
    folder.succeed(&format!("{simulate} --plot a.svg --size 120x90"));
    let (width, height) = size("a.svg");
    assert!(
        (width - 120.0).abs() < 0.5 && (height - 90.0).abs() < 0.5,
        "{width} {height}"
    );
    folder.succeed(&format!(
        "{simulate} --plot b.svg --size column --plot-from 0.1 --plot-to 0.2"
    ));
    assert!((size("b.svg").0 - 85.0).abs() < 0.5);
    let shown = words(&folder, "b.svg");
    assert!(
        count(&shown, "0.100") == 1 && count(&shown, "0.5") == 0,
        "{shown:?}"
    );
    // A drawing is scaled.
    folder.succeed("paper figure fig1 --plot c.svg --size page");
    assert!((size("c.svg").0 - 170.0).abs() < 0.5);
    let small = format!("{simulate} --plot d.svg --size 20x20");
    folder.fail(&small, 2, &["--size", "too small", "needs"]);
    let wrong = format!("{simulate} --plot d.svg --size poster");
    folder.fail(&wrong, 2, &["poster", "column, page, slide", "120x80"]);
    for alone in ["--size page", "--plot-to 0.2"] {
        folder.fail(&format!("{simulate} {alone}"), 2, &["--plot"]);
    }
    let nowhere = format!("{simulate} --plot d.svg --plot-from 7");
    folder.fail(&nowhere, 2, &["--plot-from 7", "within the figure's 0 to"]);
    assert_eq!(folder.names(), ["a.svg", "b.svg", "c.svg"]);
}

#[test]
fn a_pdf_has_the_page_and_the_words() {
    let folder = Folder::new();
    folder.succeed(&format!(
        "simulate {} --method hfcr --plot run.pdf --size 127x101.6",
        scene("fig2")
    ));
    let bytes = std::fs::read(folder.path("run.pdf")).unwrap();
    assert!(bytes.starts_with(b"%PDF-1."));
    let text = String::from_utf8_lossy(&bytes);
    assert!(
        text.contains("/MediaBox [0 0 360 288]"),
        "5 x 4 inches in points"
    );
    for word in ["(hfcr)", "(time [s])", "/Helvetica", "%%EOF"] {
        assert!(text.contains(word), "{word}");
    }
}
