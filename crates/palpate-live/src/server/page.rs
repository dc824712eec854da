//! The page itself, inside the program: one line for each file.

/// A file of the page.
#[derive(Clone, Copy, Debug)]
pub struct File {
    /// Path of the request.
    pub path: &'static str,
    /// MIME type.
    pub content_type: &'static str,
    /// Content.
    pub bytes: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const PICTURE: &str = "image/svg+xml";
const TEXT: &str = "text/plain; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! file {
    ($path:literal, $content_type:expr, $file:literal) => {
        File {
            path: $path,
            content_type: $content_type,
            bytes: include_bytes!(concat!("../../page/", $file)),
        }
    };
}

/// All of it.
pub const FILES: &[File] = &[
    file!("/", HTML, "index.html"),
    file!("/icon.svg", PICTURE, "icon.svg"),
    file!("/style.css", STYLE, "style.css"),
    file!("/panel.css", STYLE, "panel.css"),
    file!("/curves.css", STYLE, "curves.css"),
    file!("/layout.css", STYLE, "layout.css"),
    file!("/axis.js", SCRIPT, "axis.js"),
    file!("/banners.js", SCRIPT, "banners.js"),
    file!("/bins.js", SCRIPT, "bins.js"),
    file!("/chart.js", SCRIPT, "chart.js"),
    file!("/charts.js", SCRIPT, "charts.js"),
    file!("/chooser.js", SCRIPT, "chooser.js"),
    file!("/contact.js", SCRIPT, "contact.js"),
    file!("/csv.js", SCRIPT, "csv.js"),
    file!("/curves.js", SCRIPT, "curves.js"),
    file!("/devices.js", SCRIPT, "devices.js"),
    file!("/field.js", SCRIPT, "field.js"),
    file!("/hand.js", SCRIPT, "hand.js"),
    file!("/hand_in_space.js", SCRIPT, "hand_in_space.js"),
    file!("/ink.js", SCRIPT, "ink.js"),
    file!("/led.js", SCRIPT, "led.js"),
    file!("/link.js", SCRIPT, "link.js"),
    file!("/main.js", SCRIPT, "main.js"),
    file!("/methods.js", SCRIPT, "methods.js"),
    file!("/model.js", SCRIPT, "model.js"),
    file!("/news.js", SCRIPT, "news.js"),
    file!("/pace.js", SCRIPT, "pace.js"),
    file!("/picture.js", SCRIPT, "picture.js"),
    file!("/protocol.js", SCRIPT, "protocol.js"),
    file!("/range.js", SCRIPT, "range.js"),
    file!("/refusal.js", SCRIPT, "refusal.js"),
    file!("/ring.js", SCRIPT, "ring.js"),
    file!("/save.js", SCRIPT, "save.js"),
    file!("/scene.js", SCRIPT, "scene.js"),
    file!("/seen.js", SCRIPT, "seen.js"),
    file!("/shapes.js", SCRIPT, "shapes.js"),
    file!("/si.js", SCRIPT, "si.js"),
    file!("/slide.js", SCRIPT, "slide.js"),
    file!("/status.js", SCRIPT, "status.js"),
    file!("/theme.js", SCRIPT, "theme.js"),
    file!("/model_values.js", SCRIPT, "model_values.js"),
    file!("/tool_names.js", SCRIPT, "tool_names.js"),
    file!("/toolbar.js", SCRIPT, "toolbar.js"),
    file!("/safety_stops.js", SCRIPT, "safety_stops.js"),
    file!("/space.js", SCRIPT, "space.js"),
    file!("/view.js", SCRIPT, "view.js"),
    file!("/hand_target.js", SCRIPT, "hand_target.js"),
    file!("/world.css", STYLE, "world.css"),
    file!("/world.html", HTML, "world.html"),
    file!("/world.js", SCRIPT, "world.js"),
    file!("/vendor/three/three.js", SCRIPT, "vendor/three/three.js"),
    file!("/vendor/three/LICENSE", TEXT, "vendor/three/LICENSE"),
    file!("/vendor/uplot/uPlot.css", STYLE, "vendor/uplot/uPlot.css"),
    file!("/vendor/uplot/uPlot.js", SCRIPT, "vendor/uplot/uPlot.js"),
    file!("/vendor/uplot/LICENSE", TEXT, "vendor/uplot/LICENSE"),
];

/// The file at a path.
#[must_use]
pub fn file(path: &str) -> Option<&'static File> {
    FILES.iter().find(|file| file.path == path)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All files of the page are included; nothing is loaded from elsewhere.
    #[test]
    fn the_page_is_all_here() {
        for file in FILES {
            let text = std::str::from_utf8(file.bytes).unwrap();
            assert!(!text.is_empty(), "{}", file.path);
            let same = FILES.iter().filter(|other| other.path == file.path);
            assert_eq!(same.count(), 1, "{}", file.path);
            let asks: &[&str] = match file.content_type {
                HTML => &["src=\"", "href=\""],
                SCRIPT => &["import \"", " from \"", "import(\""],
                STYLE => &["url(\"", "url(", "@import \""],
                _ => &[],
            };
            let (folder, _) = file.path.rsplit_once('/').unwrap();
            for ask in asks {
                for part in text.split(ask).skip(1) {
                    let named = part.split(['"', ')']).next().unwrap();
                    let path = format!("{folder}/{}", named.trim_start_matches("./"));
                    assert!(super::file(&path).is_some(), "{}: {named}", file.path);
                }
            }
        }
    }

    #[test]
    fn no_file_of_the_page_is_forgotten() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/page");
        for entry in std::fs::read_dir(folder).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let path = match name.as_str() {
                "index.html" => "/".to_owned(),
                // For the tests of the modules, which run without a browser.
                "package.json" | "vendor" => continue,
                _ => format!("/{name}"),
            };
            assert!(super::file(&path).is_some(), "{name}");
        }
    }
}
