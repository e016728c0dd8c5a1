use super::super::text::check;
use super::*;

fn set(points: &[[f32; 3]], counts: &[u32], basis: Basis, wrap: Wrap) -> CurveSet {
    CurveSet {
        points: points.to_vec(),
        radii: vec![0.1; points.len()],
        counts: counts.to_vec(),
        basis,
        wrap,
        ..CurveSet::default()
    }
}

/// Points of a quarter of a circle of radius 1, as Bézier's points have it (wrong by less than 3e-4).
const QUARTER: [[f32; 3]; 4] =
    [[1.0, 0.0, 0.0], [1.0, 0.552_285, 0.0], [0.552_285, 1.0, 0.0], [0.0, 1.0, 0.0]];

fn dice_of(set: &CurveSet, off: f64) -> Vec<Point> {
    let points: Vec<Point> = (0..set.points.len()).map(|at| set.point(at)).collect();
    let mut chain = Vec::new();
    assert!(basis::dice(&points, (set.basis, set.wrap), off, MOST_PIECES, &mut |point| chain.push(point)));
    chain
}

#[test]
fn chains_are_as_near_to_their_curves_as_asked() {
    for off in [1e-2, 1e-3, 1e-4] {
        let chain = dice_of(&set(&QUARTER, &[4], Basis::Bezier, Wrap::Pinned), off);
        let middles = chain.windows(2).map(|pair| {
            let [x, y] = [0, 1].map(|axis| 0.5 * (pair[0][axis] + pair[1][axis]));
            1.0 - (x * x + y * y).sqrt()
        });
        let most = middles.fold(0.0, f64::max);
        assert!(most <= off + 3e-4, "{most} for {off}");
        assert!(most > 0.05 * off, "not far more pieces than asked: {most} for {off}");
    }
}

#[test]
fn curves_begin_and_end_where_their_basis_says() {
    let ends = |basis, wrap| {
        let chain = dice_of(&set(&QUARTER, &[4], basis, wrap), 1e-3);
        [chain[0], chain[chain.len() - 1]].map(|[x, y, ..]| [x as f32, y as f32])
    };
    let [first, last] = [QUARTER[0], QUARTER[3]].map(|[x, y, _]| [x, y]);
    let close = |a: [[f32; 2]; 2], b: [[f32; 2]; 2]| {
        a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-5)
    };
    for basis in [Basis::Linear, Basis::Bezier, Basis::Bspline, Basis::CatmullRom] {
        assert!(close(ends(basis, Wrap::Pinned), [first, last]), "{basis:?}");
    }
    let [second, third] = [QUARTER[1], QUARTER[2]].map(|[x, y, _]| [x, y]);
    assert!(close(ends(Basis::CatmullRom, Wrap::Open), [second, third]));
    let closed = ends(Basis::Bspline, Wrap::Periodic);
    assert!(close([closed[0]; 2], [closed[1]; 2]), "{closed:?}");
}

#[test]
fn what_cannot_be_drawn_is_left_out_with_a_word() {
    let points = [[0.0; 3], [0.0, 1.0, 0.0], [f32::NAN, 0.0, 0.0], [1.0; 3], [2.0; 3], [2.0; 3], [3.0; 3]];
    let all = set(&points, &[2, 2, 2, 1], Basis::Linear, Wrap::Pinned);
    let built = all.build(None).expect("one remains");
    assert_eq!(built.curves.curves(), 1);
    assert_eq!(
        built.left_out,
        [
            "1 curve is left out: with places or radii that are no numbers, or too large",
            "1 curve is left out: with another number of points than their basis takes (2 or more)",
            "1 curve is left out: without a length",
        ]
    );
    let thin = CurveSet { radii: vec![0.0; 2], ..set(&points[..2], &[2], Basis::Linear, Wrap::Pinned) };
    let error = thin.build(None).err().expect("nothing remains");
    assert_eq!(
        error,
        "there is no curve to be drawn: 1 curve is left out: without a thickness (all radii are 0)"
    );
    let short = set(&points[..2], &[3], Basis::Linear, Wrap::Pinned);
    assert!(short.build(None).is_err_and(|error| error.contains("3 points in all")));
}

#[test]
fn texts_say_curves_and_what_is_wrong_with_them() {
    let text = b"# two\nbasis catmull-rom\nradius 0.1 0.02\ncurve 0.5 0.25\n0 0 0\n0 1 0\n0 2 0 0.3\ncurve 0 1\n1 0 0\n1 2 0\n";
    assert_eq!(check(text), Ok(2));
    for (text, wanted) in [
        (&b"0 0 0\n"[..], "line 1: a point stands before the first `curve`"),
        (b"curve\n0 0\n", "line 2: a point has 2 numbers"),
        (b"curve\n0 0 nan\n", "line 2: `nan` is no number"),
        (b"basis cubic\n", "line 1: `basis` is `cubic`"),
        (b"curve 1\n", "line 1: `curve` has two texture coordinates"),
        (b"curve\n0 0 0 -1\n", "line 2: a radius or a colour is below 0"),
        (b"", "line 1: there is no `curve`"),
        (b"curve\n0 0 0\n", "there is no curve to be drawn"),
        (b"curve\n\xff\n", "line 2: this is no text"),
    ] {
        let error = check(text).expect_err("it is wrong");
        assert!(error.starts_with(wanted), "{error}");
    }
}
