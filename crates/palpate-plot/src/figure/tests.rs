//! Properties of complete figures that readers of the file rely on.

use super::*;

/// Draws a figure in its natural size.
fn svg(figure: &impl Picture) -> String {
    super::svg(figure, Size::NATURAL).unwrap()
}

fn series(name: &str, role: Role, kind: Kind, y: impl Fn(f64) -> f64, count: u32) -> Series {
    let x: Vec<f64> = (0..count)
        .map(|i| f64::from(i) / f64::from(count - 1))
        .collect();
    let y = x.iter().map(|&x| y(x)).collect();
    let name = name.to_owned();
    Series {
        name,
        kind,
        role,
        x,
        y,
    }
}

fn figure(columns: usize, rows: usize, series: &[Series]) -> Figure {
    let panel = Panel {
        series: series.to_vec(),
    };
    let row = Row {
        y_label: "force [N]".to_owned(),
        y_decades: false,
        limits: Limits::default(),
        panels: vec![panel; columns],
    };
    Figure {
        title: "A figure".to_owned(),
        subtitle: "of nothing".to_owned(),
        footnote: Some("In small print.".to_owned()),
        x_label: "time [s]".to_owned(),
        x_decades: false,
        columns: (0..columns)
            .map(|column| format!("column {column}"))
            .collect(),
        rows: vec![row; rows],
    }
}

/// Returns a series that alternates at every sample, so that thinning may not drop any sample unnoticed.
fn noise(number: usize, kind: Kind, count: u32) -> Series {
    let wave = move |x: f64| (1e6 * x * (number as f64 + 1.3)).sin() * (1.0 + x);
    series(
        &format!("method {number}"),
        Role::Compared(number),
        kind,
        wave,
        count,
    )
}

fn parse(document: &str) -> roxmltree::Document<'_> {
    roxmltree::Document::parse(document).unwrap()
}

/// Asserts that every number of every coordinate in the document is finite and near the page.
fn assert_on_page(document: &str) {
    for word in ["NaN", "nan", "inf"] {
        assert!(
            !document.contains(&format!("{word} ")) && !document.contains(&format!("\"{word}"))
        );
    }
    let tree = parse(document);
    for node in tree.descendants() {
        for name in [
            "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "d", "width", "height",
        ] {
            let Some(value) = node.attribute(name) else {
                continue;
            };
            for number in
                value.split(|c: char| c.is_alphabetic() || c == ' ' || c == ',' || c == '%')
            {
                if !number.is_empty() {
                    let number: f64 = number.parse().unwrap();
                    assert!(number.abs() < 3000.0, "{name}={value}");
                }
            }
        }
    }
}

#[test]
fn the_same_figure_gives_the_same_bytes() {
    let figure = figure(
        2,
        3,
        &[noise(0, Kind::Line, 1000), noise(1, Kind::Step, 1000)],
    );
    let first = svg(&figure);
    assert_eq!(svg(&figure), first);
    assert!(first.contains("panel-5") && !first.contains("kuva-clip"));
}

#[test]
fn a_figure_of_any_shape_is_well_formed() {
    for columns in 0..6 {
        for rows in 0..5 {
            let figure = figure(
                columns,
                rows,
                &[noise(0, Kind::Line, 50), noise(1, Kind::Points, 9)],
            );
            assert_on_page(&svg(&figure));
        }
    }
    assert_on_page(&svg(&Figure::default()));
}

#[test]
fn a_row_that_lacks_panels_keeps_the_grid() {
    let mut figure = figure(3, 2, &[noise(0, Kind::Line, 50)]);
    figure.rows[1].panels.truncate(1);
    assert_on_page(&svg(&figure));
}

#[test]
fn values_that_are_no_number_break_the_line_and_nothing_else() {
    let wild = [
        f64::NAN,
        0.0,
        f64::INFINITY,
        1.0,
        f64::NEG_INFINITY,
        2.0,
        f64::MAX,
        f64::MIN,
        5e-324,
    ];
    for kind in [Kind::Line, Kind::Step, Kind::Points] {
        for limits in [Limits::Data, Limits::default()] {
            for x in [
                (0..wild.len()).map(|i| i as f64).collect::<Vec<f64>>(),
                wild.to_vec(),
                vec![f64::NAN; wild.len()],
            ] {
                let (name, role) = ("wild".to_owned(), Role::Compared(0));
                let series = Series {
                    name,
                    kind,
                    role,
                    x,
                    y: wild.to_vec(),
                };
                let mut figure = figure(1, 1, &[series]);
                figure.rows[0].limits = limits;
                assert_on_page(&svg(&figure));
            }
        }
    }
}

#[test]
fn words_from_outside_do_not_break_the_document() {
    let mut figure = figure(1, 1, &[noise(0, Kind::Line, 10)]);
    let words = "a<b> & \"c\" 'd' \u{0}\u{1b}\u{ffff}\n$x$ \\ µ ]]>";
    figure.title = words.to_owned();
    figure.footnote = Some(words.to_owned());
    figure.x_label = words.to_owned();
    figure.columns = vec![words.to_owned()];
    figure.rows[0].y_label = words.to_owned();
    figure.rows[0].panels[0].series[0].name = words.to_owned();
    let document = svg(&figure);
    assert!(parse(&document).descendants().any(|node| {
        node.text()
            .is_some_and(|text| text.starts_with("a<b> & \"c\" 'd'"))
    }));
}

#[test]
fn a_long_run_stays_small_and_keeps_its_peaks() {
    let mut methods: Vec<Series> = (0..8)
        .map(|number| noise(number, Kind::Line, 100_000))
        .collect();
    methods[3].y[77_777] = 4.5;
    methods[5].kind = Kind::Step;
    let mut figure = figure(1, 4, &methods);
    for row in &mut figure.rows {
        row.limits = Limits::Data;
    }
    let document = svg(&figure);
    assert!(document.len() < 2_000_000, "{} bytes", document.len());
    let flat = svg(&{
        let mut figure = figure.clone();
        for row in &mut figure.rows {
            row.panels[0].series[3].y[77_777] = 0.0;
        }
        figure
    });
    assert_ne!(document, flat, "the peak of one sample is drawn");
    assert_on_page(&document);
}

#[test]
fn the_frames_of_a_column_stand_above_each_other() {
    let mut figure = figure(1, 2, &[noise(0, Kind::Line, 10)]);
    figure.rows[0].panels[0].series[0].y[5] = -12_345.678;
    figure.rows[0].limits = Limits::Data;
    figure.rows[0].y_label = "a label that is long enough to take two lines [N]".to_owned();
    let document = svg(&figure);
    let tree = parse(&document);
    let frames: Vec<(&str, &str)> = tree
        .descendants()
        .filter(|node| node.has_tag_name("clipPath"))
        .map(|node| node.first_element_child().unwrap())
        .map(|frame| {
            (
                frame.attribute("x").unwrap(),
                frame.attribute("width").unwrap(),
            )
        })
        .collect();
    assert_eq!(frames.len(), 2);
    assert_eq!(frames[0], frames[1]);
}

#[test]
fn what_leaves_a_panel_is_named() {
    let calm = series("ideal", Role::Reference, Kind::Line, f64::sin, 100);
    let wild = series(
        "basic",
        Role::Compared(0),
        Kind::Line,
        |x| (50.0 * x).exp(),
        100,
    );
    let document = svg(&figure(1, 1, &[wild.clone(), calm.clone()]));
    assert!(document.contains("off scale: basic \u{25b2}<"));
    let document = svg(&figure(4, 1, &[wild, calm.clone()]));
    assert!(document.contains("off scale: basic \u{25b2}<"));
    assert!(!svg(&figure(1, 1, &[calm])).contains("off scale"));
}

#[test]
fn each_name_stands_in_the_legend_once() {
    let methods: Vec<Series> = (0..8).map(|number| noise(number, Kind::Line, 10)).collect();
    let document = svg(&figure(3, 3, &methods));
    for number in 0..8 {
        assert_eq!(document.matches(&format!(">method {number}<")).count(), 1);
    }
}

#[test]
fn words_of_dots_stay_on_a_narrow_page() {
    let panel = |head: &str| DotPanel {
        head: head.into(),
        floor: Some(0.1),
        dots: vec![Dot {
            name: "a method with a name".into(),
            value: Some(900.0),
            ring: true,
            note: String::new(),
        }],
    };
    let figure = DotFigure {
        x_label: "error [%]".into(),
        largest: 1000.0,
        floor_label: "floor".into(),
        ring_label: "diverged, left the safety box or jammed".into(),
        panels: vec![panel("the first one at 360 Hz"), panel("another")],
        ..DotFigure::default()
    };
    for size in ["column", "120x90", "page"] {
        let document = super::svg(&figure, size.parse().unwrap()).unwrap();
        let tree = parse(&document);
        let number =
            |node: roxmltree::Node, name| -> f64 { node.attribute(name).unwrap().parse().unwrap() };
        let page = number(tree.root_element(), "width");
        let mut numbers = Vec::new();
        for node in tree.descendants().filter(|node| node.has_tag_name("text")) {
            let (words, x) = (node.text().unwrap(), number(node, "x"));
            let width = text::width(words, node.attribute("font-size").unwrap().parse().unwrap());
            let before = match node.attribute("text-anchor") {
                Some("middle") => 0.5 * width,
                Some("end") => width,
                _ => 0.0,
            };
            assert!(
                x - before >= 0.0 && x - before + width <= page,
                "{size}: {words}"
            );
            assert_ne!(words, "Hz", "{size}: a unit stays with its number");
            if words.parse::<f64>().is_ok() {
                numbers.push((number(node, "y"), x - before, width));
            }
        }
        numbers.sort_by(|a, b| a.partial_cmp(b).unwrap());
        for pair in numbers.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            assert!(pair[0].1 + pair[0].2 < pair[1].1, "{size}: {pair:?}");
        }
    }
}

#[cfg(feature = "png")]
#[test]
fn a_png_is_the_same_each_time() {
    let figure = figure(
        1,
        2,
        &[noise(0, Kind::Line, 100), noise(3, Kind::Step, 100)],
    );
    let first = png(&figure, Size::NATURAL, 2.0).unwrap();
    assert!(first.starts_with(b"\x89PNG"));
    assert_eq!(png(&figure, Size::NATURAL, 2.0).unwrap(), first);
}

#[test]
fn grids_side_by_side_keep_level_and_end_where_a_wide_one_does() {
    let far = series("far", Role::Compared(1), Kind::Line, |x| 1e4 * x, 50);
    let near = series("near", Role::Reference, Kind::Line, |x| x, 50);
    let one = figure(1, 2, &[near, far]);
    let grid = |heads: &[&str]| Grid {
        heads: heads.iter().map(|head| (*head).to_owned()).collect(),
        rows: one.rows.clone(),
        ..Grid::default()
    };
    let sheet = |lines| Sheet {
        title: one.title.clone(),
        x_label: one.x_label.clone(),
        lines,
        ..Sheet::default()
    };
    let long = "a head that leaves no room for all of the note beside it";
    let document = svg(&sheet(vec![
        vec![grid(&["first", long]), grid(&[])],
        vec![grid(&[])],
    ]));
    assert_on_page(&document);
    let tree = parse(&document);
    let place = |words: &str| -> Vec<(f64, f64)> {
        let number = |node: roxmltree::Node, name| node.attribute(name).unwrap().parse().unwrap();
        tree.descendants()
            .filter(|node| node.text() == Some(words) && node.has_tag_name("text"))
            .map(|node| (number(node, "x"), number(node, "y")))
            .collect()
    };
    assert_eq!(place("first").len(), 1);
    // Six panels, six notes: a short one if the heading takes the space.
    let (full, short) = (
        place("off scale: far \u{25b2}"),
        place("\u{25b2} off scale: 1 of 2 series"),
    );
    assert_eq!((full.len(), short.len()), (5, 1), "{full:?} {short:?}");
    // Notes end at the right end of their frames. In each line of grids the first rows are level.
    let head = place("first")[0];
    assert_eq!(full[0].1, head.1);
    let (left, right, wide) = (full[0], full[1], full[3]);
    assert_eq!(left.1, right.1, "{full:?}");
    // Each note is within the frame of its own grid; the margin right of each frame is 16 px.
    let end = left.0 + 16.0 + right.0;
    assert!((wide.0 - end).abs() < 0.1, "{full:?}");
}
