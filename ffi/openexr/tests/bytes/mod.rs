//! Makes EXR files byte by byte, after the description of the format ("OpenEXR File Layout"): what our writer refuses,
//! such as NaNs, several parts, windows that begin elsewhere, and parts that are tiled or deep.
#![allow(dead_code, reason = "each test binary uses its share")]

/// A part; nothing is compressed.
pub struct Part<'a> {
    /// Its name, which files of several parts need.
    pub name: &'a str,
    /// `scanlineimage`, `tiledimage` or `deepscanline`. The last two have no pixels here.
    pub kind: &'a str,
    /// First column and row, last column and row.
    pub window: [i32; 4],
    /// Names in rising order, and values, which are stored as floats, row by row.
    pub channels: &'a [(&'a str, &'a [f32])],
}

impl Part<'_> {
    fn width(&self) -> usize {
        (self.window[2] - self.window[0] + 1) as usize
    }

    fn height(&self) -> usize {
        (self.window[3] - self.window[1] + 1) as usize
    }

    fn is_scanline(&self) -> bool {
        self.kind == "scanlineimage"
    }

    fn header(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut put = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
            bytes.extend((value.len() as i32).to_le_bytes());
            bytes.extend(value);
        };
        let window: Vec<u8> = self.window.iter().flat_map(|side| side.to_le_bytes()).collect();
        put("channels", "chlist", &self.channel_list());
        put("chunkCount", "int", &(self.height() as i32).to_le_bytes());
        put("compression", "compression", &[0]);
        put("dataWindow", "box2i", &window);
        put("displayWindow", "box2i", &window);
        put("lineOrder", "lineOrder", &[0]);
        put("name", "string", self.name.as_bytes());
        put("pixelAspectRatio", "float", &1_f32.to_le_bytes());
        put("screenWindowCenter", "v2f", &[0; 8]);
        put("screenWindowWidth", "float", &1_f32.to_le_bytes());
        put("type", "string", self.kind.as_bytes());
        match self.kind {
            "tiledimage" => put("tiles", "tiledesc", &[self.width() as u8, 0, 0, 0, 1, 0, 0, 0, 0]),
            "deepscanline" => {
                put("version", "int", &1_i32.to_le_bytes());
                put("maxSamplesPerPixel", "int", &1_i32.to_le_bytes());
            }
            _ => {}
        }
        bytes.push(0);
        bytes
    }

    fn channel_list(&self) -> Vec<u8> {
        let mut list = Vec::new();
        for (name, _) in self.channels {
            list.extend([name.as_bytes(), b"\0"].concat());
            // floats, perceptually logarithmic, reserved, sampled in each pixel
            for number in [2_i32, 0, 1, 1] {
                list.extend(number.to_le_bytes());
            }
        }
        list.push(0);
        list
    }

    /// One chunk a line.
    fn chunks(&self, number: Option<usize>) -> Vec<Vec<u8>> {
        let line = |row: usize| {
            let mut chunk = Vec::new();
            chunk.extend(number.map(|number| (number as i32).to_le_bytes()).into_iter().flatten());
            chunk.extend((self.window[1] + row as i32).to_le_bytes());
            chunk.extend(((self.width() * self.channels.len() * 4) as i32).to_le_bytes());
            for (_, values) in self.channels {
                let values = &values[row * self.width()..(row + 1) * self.width()];
                chunk.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            }
            chunk
        };
        if self.is_scanline() {
            (0..self.height()).map(line).collect()
        } else {
            vec![Vec::new(); self.height()]
        }
    }
}

/// The bytes of a file that has these parts.
pub fn file(parts: &[Part<'_>]) -> Vec<u8> {
    let several = parts.len() > 1;
    let flags = match parts {
        _ if several => 0x1000 | if parts.iter().any(|part| part.kind == "deepscanline") { 0x800 } else { 0 },
        [Part { kind: "tiledimage", .. }] => 0x200,
        [Part { kind: "deepscanline", .. }] => 0x800,
        _ => 0_u32,
    };
    let mut bytes = Vec::new();
    bytes.extend(20_000_630_u32.to_le_bytes());
    bytes.extend((2 | flags).to_le_bytes());
    parts.iter().for_each(|part| bytes.extend(part.header()));
    if several {
        bytes.push(0);
    }
    let chunks: Vec<Vec<u8>> =
        parts.iter().enumerate().flat_map(|(number, part)| part.chunks(several.then_some(number))).collect();
    let mut at = bytes.len() as u64 + 8 * chunks.len() as u64;
    for chunk in &chunks {
        bytes.extend(if chunk.is_empty() { 0 } else { at }.to_le_bytes());
        at += chunk.len() as u64;
    }
    bytes.extend(chunks.concat());
    bytes
}
