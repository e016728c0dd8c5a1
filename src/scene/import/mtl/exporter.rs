//! Programs that write MTL files, by the comments at the beginning.

/// Number of lines at the beginning of a file in which its exporter is looked for.
const HEADER_LINES: usize = 8;

/// Program that wrote a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Exporter {
    /// Blender, by its header.
    Blender,
    /// Any other.
    #[default]
    Other,
}

impl Exporter {
    /// Recognises the exporter by the comments at the beginning of the file.
    pub fn of(text: &[u8]) -> Self {
        let mut header =
            text.split(|byte| *byte == b'\n').take(HEADER_LINES).filter(|line| line.starts_with(b"#"));
        let is_blender = |line: &[u8]| line.windows(7).any(|word| word == b"Blender");
        if header.any(is_blender) { Self::Blender } else { Self::Other }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLENDER: &str = "# Blender 5.0.1 MTL File: 'shot.blend'\n# www.blender.org\n\n";

    #[test]
    fn the_header_alone_names_the_exporter() {
        let late = format!("{}# Blender\n", "newmtl a\n".repeat(20));
        for (text, exporter) in [
            (BLENDER, Exporter::Blender),
            ("# Blender MTL File: 'None'\n", Exporter::Blender),
            ("newmtl Blender\n", Exporter::Other),
            (late.as_str(), Exporter::Other),
            ("", Exporter::Other),
        ] {
            assert_eq!(Exporter::of(text.as_bytes()), exporter, "{text}");
        }
    }
}
