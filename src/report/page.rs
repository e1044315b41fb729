//! The report as a page.

use std::fmt::{self, Display, Write};

use super::{Report, ReportEntry, ReportMethod, promises_surfaces};

/// Style of the page, for light and dark.
const STYLE: &str = "\
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 68rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: .5rem 0 1.5rem; font-variant-numeric: tabular-nums; }
th, td { white-space: nowrap; padding: .15rem .7rem; text-align: right; border-bottom: 1px solid #8885; }
th:first-child, td:first-child { text-align: left; }
div { overflow-x: auto; }
.bar { display: inline-block; height: .7em; background: #4a7fc1; vertical-align: baseline; }
.wrong { color: #c33; font-weight: 600; }
.note { opacity: .75; }
";

impl Report {
    /// Returns the report as an HTML page that needs no other file. With the feature `json` it contains the JSON form,
    /// in the element `report`.
    pub fn to_html(&self) -> String {
        let mut page = String::new();
        self.write(&mut page).expect("a string takes all text");
        page
    }

    fn write(&self, page: &mut String) -> fmt::Result {
        let adapter = Escaped(&self.adapter);
        writeln!(
            page,
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
             content=\"width=device-width\">\n<title>stereotrace on {adapter}</title>\n<style>\n{STYLE}</style>\n\
             <h1>stereotrace {} on {adapter}</h1>",
            self.version
        )?;
        let tracing = if self.ray_queries { "ray queries" } else { "kernels" };
        writeln!(page, "<p>Driver: {}. Rays are traced by {tracing}. {}.</p>", Escaped(&self.driver), self.clock())?;
        let limits = self.limits.iter().map(|(name, value)| format!("{name} {value}"));
        writeln!(page, "<p class=\"note\">{}.</p>", Vec::from_iter(limits).join(", "))?;
        writeln!(
            page,
            "<p>The first picture took {:.0} ms, of which most is the compilation of kernels unless the driver kept \
             them. The report took {:.1} s.</p>",
            1e3 * self.first_picture.as_secs_f64(),
            self.took.as_secs_f64()
        )?;
        writeln!(
            page,
            "<p>A primary ray takes {:.1} ns. auto chooses by measured costs, in primary rays: {:.2} per pixel for the \
             search of bracket, {:.2} for a shadow ray that it saves.</p>",
            1e9 * self.calibration.ray_seconds,
            self.calibration.search,
            self.calibration.shadow
        )?;
        let faults = self.faults();
        if faults.is_empty() && !self.entries.is_empty() {
            writeln!(page, "<p>Every method that promises the surfaces of naive shows them.</p>")?;
        }
        for fault in faults {
            writeln!(page, "<p class=\"wrong\">{fault}.</p>")?;
        }
        self.entries.iter().try_for_each(|entry| entry.write(page))?;
        for (scene, [width, height]) in &self.left_out {
            writeln!(page, "<p>Left out for lack of time: {scene} at {width}x{height}.</p>")?;
        }
        writeln!(
            page,
            "<p class=\"note\">2nd eye: time of a pair divided by the time of a pair by ideal, which copies the first \
             eye, less one. traced: share of right pixels that were traced. identical and wrong (another surface): \
             right pixels compared with naive. rays: those of both eyes, in millions.</p>"
        )?;
        #[cfg(feature = "json")]
        writeln!(
            page,
            "<script type=\"application/json\" id=\"report\">\n{}</script>",
            self.to_json().replace('<', "\\u003c")
        )?;
        writeln!(page, "</html>")
    }

    fn clock(&self) -> &'static str {
        if self.timestamps { "Times are from timestamps on the device" } else { "Times are by the host's clock" }
    }
}

impl ReportEntry {
    fn write(&self, page: &mut String) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(page, "<h2>{}, {width}x{height}</h2>", self.scene)?;
        let mib = self.scene_bytes as f64 / f64::from(1 << 20);
        let build = 1e3 * self.build.as_secs_f64();
        let known = match self.has_known_ids {
            Some(true) => "; the ids of primitives are those of a software adapter",
            Some(false) => "; some ids of primitives differ from those of a software adapter",
            None => "",
        };
        writeln!(
            page,
            "<p>{} primitives, {mib:.1} MiB on the device, built in {build:.0} ms{known}.</p>",
            self.primitives
        )?;
        let heads =
            ["method", "pair, ms", "range", "2nd eye", "traced", "identical", "wrong", "rays", "buffers, MiB", ""];
        let heads = heads.map(|head| format!("<th>{head}</th>")).concat();
        writeln!(page, "<div><table>\n<tr>{heads}</tr>")?;
        let longest = self.methods.iter().map(|row| row.pair).max().unwrap_or_default().as_secs_f64();
        self.methods.iter().try_for_each(|row| row.write(page, longest))?;
        writeln!(page, "</table></div>")
    }
}

impl ReportMethod {
    fn write(&self, page: &mut String, longest: f64) -> fmt::Result {
        let chosen = self.chosen.map_or(String::new(), |method| format!(" ({method})"));
        let [low, high] = self.range.map(|time| 1e3 * time.as_secs_f64());
        let rays = self.rays.iter().map(crate::Rays::total).sum::<u64>() as f64 / 1e6;
        // The percentage is rounded down, so that 100.00 means that all pixels are identical.
        let identical = (100.0 * self.identical_percent).floor() / 100.0;
        let wrong = self.wrong_surface_percent;
        let class = if wrong > 0.0 && promises_surfaces(self.method) { " class=\"wrong\"" } else { "" };
        writeln!(
            page,
            "<tr><td>{}{chosen}</td><td>{:.2}</td><td>{low:.2} to {high:.2}</td><td>{:.3}</td><td>{:.1}%</td>\
             <td>{identical:.2}%</td><td{class}>{wrong:.3}%</td><td>{rays:.2}</td><td>{:.1}</td>\
             <td style=\"text-align:left\"><span class=\"bar\" style=\"width:{:.1}em\"></span></td></tr>",
            self.method,
            1e3 * self.pair.as_secs_f64(),
            self.second_eye,
            100.0 * self.retraced,
            self.intermediate_bytes as f64 / f64::from(1 << 20),
            12.0 * self.pair.as_secs_f64() / longest.max(1e-9),
        )
    }
}

/// A text in which no character has a meaning in HTML.
struct Escaped<'a>(&'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for letter in self.0.chars() {
            match letter {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                letter => f.write_char(letter)?,
            }
        }
        Ok(())
    }
}
