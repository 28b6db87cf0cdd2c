//! Pages: the skeleton and the style sheet that all pages share.

/// The style sheet of all pages: light and dark, headings, tables, charts, figures.
const STYLE: &str = include_str!("style.css");

/// Returns a page that opens offline. `body` is HTML; `style` is CSS beyond that of all pages.
#[must_use]
pub fn page(title: &str, style: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>\n{STYLE}{style}</style>\n</head>\n\
         <body>\n{body}\n</body>\n</html>\n",
        escape(title)
    )
}

/// Returns text as HTML, also for the value of an attribute in double quotes.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_complete_and_its_title_is_escaped() {
        let html = page("a < b", "i { color: red; }\n", "<h1>Title</h1>");
        assert!(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"));
        assert!(html.contains("<title>a &lt; b</title>") && html.contains("i { color: red; }"));
        assert!(html.contains("<body>\n<h1>Title</h1>\n</body>"));
    }

    #[test]
    fn text_cannot_end_an_attribute_or_start_a_tag() {
        assert_eq!(escape("<a href=\"&\">"), "&lt;a href=&quot;&amp;&quot;&gt;");
    }
}
