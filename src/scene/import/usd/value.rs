//! Values of attributes, whatever their type in the file.

use std::fmt::Display;

use glam::DVec3;
use openusd::gf;
use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, TimeCode};

use super::clock::Clock;

/// Outcome of a question to the library; the error is what it says.
pub type Answer<T> = Result<T, String>;

/// Why a prim is not shown as its file has it.
#[derive(Debug)]
pub enum PrimError {
    /// It makes no sense: it is left out, and all else is shown.
    Damaged(String),
    /// Nothing can be shown, such as for want of memory.
    Fatal(String),
}

impl From<String> for PrimError {
    fn from(what: String) -> Self {
        Self::Damaged(what)
    }
}

/// What is read of a prim.
pub type Read<T> = Result<T, PrimError>;

/// Largest number of times of an attribute.
const MOST_TIMES: usize = 1 << 20;

/// Converts the library's errors to what they say.
pub fn said<T, E: Display>(answer: Result<T, E>) -> Answer<T> {
    answer.map_err(|error| format!("{error:#}"))
}

/// Returns true if an attribute may have this `name`. Files state names of attributes, and the library does not return if it is asked for
/// one with other characters.
pub fn is_name(name: &str) -> bool {
    name.chars().all(|letter| letter.is_alphanumeric() || matches!(letter, '_' | ':'))
}

/// Value of an attribute at a time code.
pub fn value(prim: &Prim, name: &str, code: f64) -> Answer<Option<Value>> {
    if !is_name(name) {
        return Ok(None);
    }
    said(prim.attribute(name).get_at::<Value>(TimeCode::from(code)))
}

/// Time codes at which an attribute has values; none, or one alone, if it rests.
///
/// # Errors More times than anybody needs, or such as are not finite.
pub fn codes(prim: &Prim, name: &str) -> Answer<Vec<f64>> {
    if !is_name(name) {
        return Ok(Vec::new());
    }
    let codes = said(prim.attribute(name).time_sample_times())?;
    if codes.len() > MOST_TIMES || !codes.iter().all(|code| code.abs() <= 1e9) {
        let path = prim.path();
        return Err(format!("`{name}` of {path} has too many times, or times beyond all bounds"));
    }
    Ok(codes)
}

/// Time codes at which an attribute has values, of those that a file's clock reads: all between the first and the last, the one before and the
/// one behind. None, or one alone, if it rests.
///
/// # Errors Those of [`codes`].
pub fn codes_read(prim: &Prim, name: &str, clock: &Clock) -> Answer<Vec<f64>> {
    let all = codes(prim, name)?;
    let Some([first, last]) = clock.read.filter(|_| !all.is_empty()) else { return Ok(all) };
    let begin = all.partition_point(|code| *code <= first).saturating_sub(1);
    let end = (all.partition_point(|code| *code < last) + 1).min(all.len());
    Ok(all[begin..end.max(begin + 1)].to_vec())
}

/// Numbers of an attribute at a time code.
///
/// Of text files the library keeps whole numbers among times as such, whatever the attribute's type, and does not interpolate them: single
/// numbers are interpolated here.
pub fn numbers_at(prim: &Prim, name: &str, code: f64) -> Answer<Option<Vec<f64>>> {
    let at =
        |code: f64| -> Answer<Option<Vec<f64>>> { Ok(value(prim, name, code)?.as_ref().and_then(numbers)) };
    let Some(own) = at(code)? else { return Ok(None) };
    let [_] = own[..] else { return Ok(Some(own)) };
    match said(prim.attribute(name).bracketing_time_samples(TimeCode::from(code)))? {
        Some((before, after)) if before < code && code < after => {
            let (Some(from), Some(to)) = (at(before)?, at(after)?) else { return Ok(Some(own)) };
            let (Some(from), Some(to)) = (from.first(), to.first()) else { return Ok(Some(own)) };
            Ok(Some(vec![from + (to - from) * (code - before) / (after - before)]))
        }
        _ => Ok(Some(own)),
    }
}

/// Number of an attribute at a time code, if it is finite.
pub fn number(prim: &Prim, name: &str, code: f64) -> Answer<Option<f64>> {
    let numbers = numbers_at(prim, name, code)?;
    Ok(numbers.and_then(|numbers| numbers.first().copied()).filter(|number| number.is_finite()))
}

/// Three numbers of an attribute at a time code, if they are finite.
pub fn three(prim: &Prim, name: &str, code: f64) -> Answer<Option<DVec3>> {
    let numbers = value(prim, name, code)?.as_ref().and_then(numbers);
    let three = numbers.filter(|numbers| numbers.len() >= 3).map(|numbers| DVec3::from_slice(&numbers));
    Ok(three.filter(|three| three.is_finite()))
}

/// Token or text of an attribute at a time code.
pub fn word(prim: &Prim, name: &str, code: f64) -> Answer<Option<String>> {
    Ok(value(prim, name, code)?.and_then(|value| match value {
        Value::Token(token) => Some(token.to_string()),
        Value::String(text) => Some(text),
        _ => None,
    }))
}

/// Truth of an attribute at a time code.
pub fn flag(prim: &Prim, name: &str, code: f64) -> Answer<Option<bool>> {
    Ok(match value(prim, name, code)? {
        Some(Value::Bool(flag)) => Some(flag),
        // with times in text layers
        Some(Value::Token(flag)) => Some(flag.as_str() == "true"),
        _ => None,
    })
}

/// Paths that a relationship names.
pub fn targets(prim: &Prim, name: &str) -> Answer<Vec<Path>> {
    said(prim.relationship(name).forwarded_targets())
}

/// Converts a vector's components to numbers.
macro_rules! flat {
    ($vectors:expr, $($part:ident),+) => {
        $vectors.iter().flat_map(|vector| [$(f64::from(vector.$part)),+]).collect()
    };
}

/// Numbers of a value, one after the other: quaternions as x, y, z, w, matrices row by row. `None` for what is no number.
pub fn numbers(value: &Value) -> Option<Vec<f64>> {
    Some(match value {
        Value::Half(number) => vec![f64::from(*number)],
        Value::Float(number) => vec![f64::from(*number)],
        Value::Double(number) => vec![*number],
        Value::Int(number) => vec![f64::from(*number)],
        Value::Uint(number) => vec![f64::from(*number)],
        Value::Int64(number) => vec![*number as f64],
        Value::Uint64(number) => vec![*number as f64],
        Value::FloatVec(list) => list.iter().copied().map(f64::from).collect(),
        Value::DoubleVec(list) => list.clone(),
        Value::HalfVec(list) => list.iter().copied().map(f64::from).collect(),
        Value::Vec2h(vector) => flat!([vector], x, y),
        Value::Vec2f(vector) => flat!([vector], x, y),
        Value::Vec2i(vector) => flat!([vector], x, y),
        Value::Vec2d(vector) => flat!([vector], x, y),
        Value::Vec3h(vector) => flat!([vector], x, y, z),
        Value::Vec3f(vector) => flat!([vector], x, y, z),
        Value::Vec3d(vector) => flat!([vector], x, y, z),
        Value::Vec3hVec(list) => flat!(list, x, y, z),
        Value::Vec3fVec(list) => flat!(list, x, y, z),
        Value::Vec3dVec(list) => flat!(list, x, y, z),
        Value::Vec4h(vector) => flat!([vector], x, y, z, w),
        Value::Vec4f(vector) => flat!([vector], x, y, z, w),
        Value::Vec4d(vector) => flat!([vector], x, y, z, w),
        Value::Quath(turn) => flat!([turn], x, y, z, w),
        Value::Quatf(turn) => flat!([turn], x, y, z, w),
        Value::Quatd(turn) => flat!([turn], x, y, z, w),
        Value::QuathVec(list) => flat!(list, x, y, z, w),
        Value::QuatfVec(list) => flat!(list, x, y, z, w),
        Value::QuatdVec(list) => flat!(list, x, y, z, w),
        Value::Matrix4d(matrix) => <[f64; 16]>::from(*matrix).to_vec(),
        Value::Matrix4dVec(list) => list.iter().flat_map(|matrix| <[f64; 16]>::from(*matrix)).collect(),
        _ => return None,
    })
}

/// Tokens or texts of a value.
pub fn words(value: &Value) -> Option<Vec<String>> {
    match value {
        Value::TokenVec(list) => Some(list.iter().map(|word| word.to_string()).collect()),
        Value::StringVec(list) => Some(list.clone()),
        _ => None,
    }
}

/// Whole numbers of a value.
pub fn whole_numbers(value: &Value) -> Option<Vec<i64>> {
    Some(match value {
        Value::Int(number) => vec![i64::from(*number)],
        Value::Uint(number) => vec![i64::from(*number)],
        Value::Int64(number) => vec![*number],
        Value::IntVec(list) => list.iter().copied().map(i64::from).collect(),
        Value::UintVec(list) => list.iter().copied().map(i64::from).collect(),
        Value::Int64Vec(list) => list.clone(),
        _ => return None,
    })
}

/// Points of a value, in single floats.
pub fn points(value: &Value) -> Option<Vec<[f32; 3]>> {
    match value {
        Value::Vec3fVec(list) => {
            Some(list.iter().map(|point: &gf::Vec3f| [point.x, point.y, point.z]).collect())
        }
        other => {
            let numbers = numbers(other)?;
            let point = |point: &[f64]| [point[0] as f32, point[1] as f32, point[2] as f32];
            Some(numbers.chunks_exact(3).map(point).collect())
        }
    }
}

/// Pairs of numbers of a value.
pub fn pairs(value: &Value) -> Option<Vec<[f32; 2]>> {
    Some(match value {
        Value::Vec2fVec(list) => list.iter().map(|pair| [pair.x, pair.y]).collect(),
        Value::Vec2dVec(list) => list.iter().map(|pair| [pair.x as f32, pair.y as f32]).collect(),
        Value::Vec2hVec(list) => list.iter().map(|pair| [f32::from(pair.x), f32::from(pair.y)]).collect(),
        Value::Vec3fVec(list) => list.iter().map(|three| [three.x, three.y]).collect(),
        _ => return None,
    })
}
