//! The colours of light: Blender's Blackbody and Wavelength nodes, as linear Rec. 709.
use super::finite_vector;
use glam::{Mat3, Vec3};

/// The coefficients of a black body's colour up to a temperature.
struct Piece {
    /// Where the next piece begins, in kelvins.
    end: f32,
    /// Red is `red[0] / t + red[1] * t + red[2]`.
    red: [f32; 3],
    /// Green, like red.
    green: [f32; 3],
    /// Blue is a cubic polynomial, the highest power first.
    blue: [f32; 4],
}

/// From 800 K on. The numbers are those of Cycles, so that colours are the same.
const PIECES: [Piece; 7] = [
    Piece {
        end: 965.0,
        red: [1619.191, -0.002_050_109_2, 5.029_958],
        green: [-488.999_76, 6.043_307_4e-4, -0.075_580_75],
        blue: [5.969_453_4e-11, -4.857_429e-8, -9.706_223e-5, -0.004_079_361_4],
    },
    Piece {
        end: 1167.0,
        red: [2488.4546, -0.001_113_309_1, 3.226_215_4],
        green: [-755.994_26, 3.167_301e-4, 0.478_306_14],
        blue: [2.404_303_7e-11, 5.550_210_6e-8, -1.985_037_1e-4, 0.028_931_286],
    },
    Piece {
        end: 1449.0,
        red: [3341.432, -4.865_512e-4, 1.764_867_7],
        green: [-1023.6398, 1.202_234_7e-4, 0.936_662_3],
        blue: [-1.409_497_35e-11, 1.898_789_7e-7, -3.566_328_4e-4, 0.091_076_78],
    },
    Piece {
        end: 1902.0,
        red: [4094.6174, -1.274_465_8e-4, 0.725_731_6],
        green: [-1265.7131, 4.873_409e-6, 1.270_545],
        blue: [-3.614_608_6e-11, 2.848_220_2e-7, -4.932_113e-4, 0.156_723_44],
    },
    Piece {
        end: 3315.0,
        red: [4670.2803, 2.912_582e-5, 0.126_703_44],
        green: [-1425.2933, -4.011_504_3e-5, 1.439_727_8],
        blue: [-1.970_757_4e-11, 1.753_593_5e-7, -2.505_428_3e-4, -0.022_278_327],
    },
    Piece {
        end: 6365.0,
        red: [4595.092, 2.874_956_4e-5, 0.150_345_03],
        green: [-1175.5482, -2.163_780_5e-5, 1.304_080_2],
        blue: [-1.619_979_5e-13, -1.642_16e-8, 3.862_162_7e-4, -0.738_077_4],
    },
    Piece {
        end: 12000.0,
        red: [3787.1746, 9.359_078e-6, 0.399_075_87],
        green: [-500.799_56, -4.598_32e-6, 1.090_987_7],
        blue: [6.726_503e-13, -2.730_788e-8, 4.240_982_5e-4, -0.752_335_67],
    },
];

/// The colour of a black body, as Blender's Blackbody node gives it: of about the luminance 1, whatever the temperature, and no
/// channel negative. The temperature is in kelvins; below 800 and from 12000 on the colour does not change.
pub fn blackbody(kelvins: f32) -> Vec3 {
    let color = if kelvins < 800.0 {
        Vec3::new(5.413_294_5, 0.0, 0.0)
    } else if let Some(piece) = PIECES.iter().find(|piece| kelvins < piece.end) {
        let Piece { red, green, blue, .. } = piece;
        let inverse = 1.0 / kelvins;
        Vec3::new(
            red[0] * inverse + red[1] * kelvins + red[2],
            green[0] * inverse + green[1] * kelvins + green[2],
            ((blue[0] * kelvins + blue[1]) * kelvins + blue[2]) * kelvins + blue[3],
        )
    } else {
        Vec3::new(0.826_295_5, 0.994_508_1, 1.566_307_7)
    };
    color.max(Vec3::ZERO)
}

/// From CIE XYZ to linear Rec. 709 with its white point, D65.
const XYZ_TO_RGB: Mat3 = Mat3::from_cols(
    Vec3::new(3.240_97, -0.969_243_6, 0.055_630_1),
    Vec3::new(-1.537_383_2, 1.875_967_5, -0.203_977),
    Vec3::new(-0.498_610_8, 0.041_555_1, 1.056_971_5),
);

/// What Cycles divides colours of wavelengths by, so that no channel exceeds 1.
const BRIGHTEST: f32 = 2.52;

/// The colour of light of one wavelength, as Blender's Wavelength node gives it: 0 to 1, without the negative channels that such
/// light has. The wavelength is in nanometres; outside of 380 to 780 the colour is black.
pub fn wavelength(nanometers: f32) -> Vec3 {
    let place = (nanometers - 380.0) / 5.0;
    // Cycles cuts fractions off towards 0, and so has the first line begin a little early.
    let index = place as usize;
    if place <= -1.0 || index >= MATCHING.len() - 1 {
        return Vec3::ZERO;
    }
    let [start, end] = [MATCHING[index], MATCHING[index + 1]].map(Vec3::from_array);
    let matched = start + (end - start) * (place - index as f32);
    finite_vector((XYZ_TO_RGB * matched / BRIGHTEST).max(Vec3::ZERO))
}

/// The colour matching functions of CIE 1931, XYZ, every 5 nm from 380 nm to 780 nm.
#[rustfmt::skip]
const MATCHING: [[f32; 3]; 81] = [
    [0.0014, 0.0000, 0.0065], [0.0022, 0.0001, 0.0105], [0.0042, 0.0001, 0.0201],
    [0.0076, 0.0002, 0.0362], [0.0143, 0.0004, 0.0679], [0.0232, 0.0006, 0.1102],
    [0.0435, 0.0012, 0.2074], [0.0776, 0.0022, 0.3713], [0.1344, 0.0040, 0.6456],
    [0.2148, 0.0073, 1.0391], [0.2839, 0.0116, 1.3856], [0.3285, 0.0168, 1.6230],
    [0.3483, 0.0230, 1.7471], [0.3481, 0.0298, 1.7826], [0.3362, 0.0380, 1.7721],
    [0.3187, 0.0480, 1.7441], [0.2908, 0.0600, 1.6692], [0.2511, 0.0739, 1.5281],
    [0.1954, 0.0910, 1.2876], [0.1421, 0.1126, 1.0419], [0.0956, 0.1390, 0.8130],
    [0.0580, 0.1693, 0.6162], [0.0320, 0.2080, 0.4652], [0.0147, 0.2586, 0.3533],
    [0.0049, 0.3230, 0.2720], [0.0024, 0.4073, 0.2123], [0.0093, 0.5030, 0.1582],
    [0.0291, 0.6082, 0.1117], [0.0633, 0.7100, 0.0782], [0.1096, 0.7932, 0.0573],
    [0.1655, 0.8620, 0.0422], [0.2257, 0.9149, 0.0298], [0.2904, 0.9540, 0.0203],
    [0.3597, 0.9803, 0.0134], [0.4334, 0.9950, 0.0087], [0.5121, 1.0000, 0.0057],
    [0.5945, 0.9950, 0.0039], [0.6784, 0.9786, 0.0027], [0.7621, 0.9520, 0.0021],
    [0.8425, 0.9154, 0.0018], [0.9163, 0.8700, 0.0017], [0.9786, 0.8163, 0.0014],
    [1.0263, 0.7570, 0.0011], [1.0567, 0.6949, 0.0010], [1.0622, 0.6310, 0.0008],
    [1.0456, 0.5668, 0.0006], [1.0026, 0.5030, 0.0003], [0.9384, 0.4412, 0.0002],
    [0.8544, 0.3810, 0.0002], [0.7514, 0.3210, 0.0001], [0.6424, 0.2650, 0.0000],
    [0.5419, 0.2170, 0.0000], [0.4479, 0.1750, 0.0000], [0.3608, 0.1382, 0.0000],
    [0.2835, 0.1070, 0.0000], [0.2187, 0.0816, 0.0000], [0.1649, 0.0610, 0.0000],
    [0.1212, 0.0446, 0.0000], [0.0874, 0.0320, 0.0000], [0.0636, 0.0232, 0.0000],
    [0.0468, 0.0170, 0.0000], [0.0329, 0.0119, 0.0000], [0.0227, 0.0082, 0.0000],
    [0.0158, 0.0057, 0.0000], [0.0114, 0.0041, 0.0000], [0.0081, 0.0029, 0.0000],
    [0.0058, 0.0021, 0.0000], [0.0041, 0.0015, 0.0000], [0.0029, 0.0010, 0.0000],
    [0.0020, 0.0007, 0.0000], [0.0014, 0.0005, 0.0000], [0.0010, 0.0004, 0.0000],
    [0.0007, 0.0002, 0.0000], [0.0005, 0.0002, 0.0000], [0.0003, 0.0001, 0.0000],
    [0.0002, 0.0001, 0.0000], [0.0002, 0.0001, 0.0000], [0.0001, 0.0000, 0.0000],
    [0.0001, 0.0000, 0.0000], [0.0001, 0.0000, 0.0000], [0.0000, 0.0000, 0.0000],
];
