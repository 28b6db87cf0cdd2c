//! The files of the page, which are part of the program: no path leads to a file on disk.

/// A file of the page.
pub(super) struct Asset {
    pub(super) media: &'static str,
    pub(super) text: &'static str,
}

const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Returns the file of this name.
pub(super) fn find(name: &str) -> Option<Asset> {
    let (media, text) = match name {
        "" => ("text/html; charset=utf-8", include_str!("page/index.html")),
        "style.css" => ("text/css; charset=utf-8", include_str!("page/style.css")),
        "main.js" => (SCRIPT, include_str!("page/main.js")),
        "address.js" => (SCRIPT, include_str!("page/address.js")),
        "connection.js" => (SCRIPT, include_str!("page/connection.js")),
        "hand.js" => (SCRIPT, include_str!("page/hand.js")),
        "inspector.js" => (SCRIPT, include_str!("page/inspector.js")),
        "panel.js" => (SCRIPT, include_str!("page/panel.js")),
        "picture.js" => (SCRIPT, include_str!("page/picture.js")),
        "statistics.js" => (SCRIPT, include_str!("page/statistics.js")),
        _ => return None,
    };
    Some(Asset { media, text })
}
