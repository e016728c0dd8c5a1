//! An OpenVDB file of a cloud: lumps with nothing between them, in nodes of which one is empty in part.

/// Cells along the edge of the cube in which it is.
const EDGE: i32 = 40;

/// The cloud, in a cube of two units around the origin: grids `density` and `heat`. Its lumps are elsewhere in each of a sequence's files, and in the
/// second one it is not hot.
pub fn cloud(number: u32) -> Vec<u8> {
    let by = |place: i32| place + 3 * (number % 4) as i32;
    let mut file = b" BDV\0\0\0\0".to_vec();
    numbers(&mut file, &[224, 12, 0]);
    file.push(1);
    file.extend([b'0'; 36]);
    // without metadata
    numbers(&mut file, &[0, 2]);
    let density = |at| 6.0 * lump(at, [by(13), 14, 12], 10.0) + 3.0 * lump(at, [29, by(30), 31], 8.0);
    let heat = |at| if number == 2 { 0.0 } else { lump(at, [by(13), 10, 12], 7.0) };
    grid(&mut file, "density", density);
    grid(&mut file, "heat", heat);
    file
}

/// A value that falls from 1 in the middle to 0.
fn lump(at: [i32; 3], middle: [i32; 3], radius: f32) -> f32 {
    let squared: i32 = at.iter().zip(middle).map(|(at, middle)| (at - middle).pow(2)).sum();
    (1.0 - (squared as f32).sqrt() / radius).max(0.0)
}

fn numbers(file: &mut Vec<u8>, all: &[u32]) {
    all.iter().for_each(|number| file.extend(number.to_le_bytes()));
}

fn text(file: &mut Vec<u8>, text: &str) {
    numbers(file, &[text.len() as u32]);
    file.extend(text.as_bytes());
}

fn doubles(file: &mut Vec<u8>, all: [f64; 3]) {
    all.iter().for_each(|number| file.extend(number.to_le_bytes()));
}

/// A grid whose values are 0 where they are not positive.
fn grid(file: &mut Vec<u8>, name: &str, value: impl Fn([i32; 3]) -> f32) {
    let mut content = Vec::new();
    // inactive values are left out
    numbers(&mut content, &[2, 0]);
    text(&mut content, "UniformScaleTranslateMap");
    let scale = 2.0 / f64::from(EDGE);
    doubles(&mut content, [-1.0; 3]);
    for of in [scale, scale, 1.0 / scale, 1.0 / (scale * scale), 0.5 / scale] {
        doubles(&mut content, [of; 3]);
    }
    // of one buffer, of nothing where nothing is said, of one upper node
    numbers(&mut content, &[1, 0, 0, 1]);
    numbers(&mut content, &[0, 0, 0]);
    node(&mut content, 32, |_| true, 1);
    let leaves: Vec<[i32; 3]> = places(16).filter(|at| at.iter().all(|along| *along < EDGE / 8)).collect();
    let points =
        |leaf: &[i32; 3]| places(8).map(|at| [0, 1, 2].map(|axis| leaf[axis] * 8 + at[axis])).collect();
    let filled = |leaf: &&[i32; 3]| -> bool {
        let points: Vec<[i32; 3]> = points(leaf);
        points.into_iter().any(|at| value(at) > 0.0)
    };
    let filled: Vec<[i32; 3]> = leaves.iter().filter(filled).copied().collect();
    node(&mut content, 16, |at| filled.contains(&at), usize::MAX);
    let mask = |leaf: &[i32; 3]| -> Vec<u8> {
        let points: Vec<[i32; 3]> = points(leaf);
        mask(points.into_iter().map(|at| value(at) > 0.0))
    };
    filled.iter().for_each(|leaf| content.extend(mask(leaf)));
    for leaf in &filled {
        content.extend(mask(leaf));
        content.push(0);
        let points: Vec<[i32; 3]> = points(leaf);
        let values = points.into_iter().map(&value).filter(|value| *value > 0.0);
        values.for_each(|value| content.extend(value.to_le_bytes()));
    }
    text(file, name);
    text(file, "Tree_float_5_4_3");
    text(file, "");
    // where it begins, where its values begin (nobody asks), and where it ends
    let begins = (file.len() + 24) as u64;
    for place in [begins, begins, begins + content.len() as u64] {
        file.extend(place.to_le_bytes());
    }
    file.extend(content);
}

/// A node of so many children along its edge, of which the first `most` are there that `is_there`, and without values.
fn node(content: &mut Vec<u8>, edge: i32, is_there: impl Fn([i32; 3]) -> bool, most: usize) {
    let children = places(edge).enumerate().map(|(number, at)| number < most && is_there(at));
    content.extend(mask(children));
    content.extend(vec![0; (edge * edge * edge / 8) as usize]);
    content.push(0);
}

/// Places of a cube, those along Z first.
fn places(edge: i32) -> impl Iterator<Item = [i32; 3]> {
    (0..edge * edge * edge).map(move |number| [number / (edge * edge), number / edge % edge, number % edge])
}

fn mask(bits: impl Iterator<Item = bool>) -> Vec<u8> {
    let bits: Vec<bool> = bits.collect();
    let byte =
        |eight: &[bool]| (0..).zip(eight).fold(0, |byte: u8, (bit, is_set)| byte | u8::from(*is_set) << bit);
    bits.chunks(8).map(byte).collect()
}
