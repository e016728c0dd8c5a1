//! Accessors: lists of numbers in buffers, of all component types, also sparse.

use super::document::Document;
use super::json::{Accessor, SparsePart};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;

/// Type of a number in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Component {
    Signed8,
    Unsigned8,
    Signed16,
    Unsigned16,
    Unsigned32,
    Float,
}

impl Component {
    fn of(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::Signed8,
            5121 => Self::Unsigned8,
            5122 => Self::Signed16,
            5123 => Self::Unsigned16,
            5125 => Self::Unsigned32,
            5126 => Self::Float,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Signed8 | Self::Unsigned8 => 1,
            Self::Signed16 | Self::Unsigned16 => 2,
            Self::Unsigned32 | Self::Float => 4,
        }
    }

    /// Reads a number from as many bytes as it has; `normalized`: whole numbers stand for -1 to 1, or 0 to 1.
    fn float(self, bytes: &[u8], normalized: bool) -> f32 {
        let (value, most) = match (self, bytes) {
            (Self::Signed8, [a]) => (f32::from(*a as i8), 127.0),
            (Self::Unsigned8, [a]) => (f32::from(*a), 255.0),
            (Self::Signed16, [a, b]) => (f32::from(i16::from_le_bytes([*a, *b])), 32767.0),
            (Self::Unsigned16, [a, b]) => (f32::from(u16::from_le_bytes([*a, *b])), 65535.0),
            (Self::Unsigned32, [a, b, c, d]) => {
                (u32::from_le_bytes([*a, *b, *c, *d]) as f32, u32::MAX as f32)
            }
            (Self::Float, [a, b, c, d]) => return f32::from_le_bytes([*a, *b, *c, *d]),
            _ => return 0.0,
        };
        if normalized { (value / most).max(-1.0) } else { value }
    }

    fn whole(self, bytes: &[u8]) -> u32 {
        match (self, bytes) {
            (Self::Unsigned8, [a]) => u32::from(*a),
            (Self::Unsigned16, [a, b]) => u32::from(u16::from_le_bytes([*a, *b])),
            (Self::Unsigned32, [a, b, c, d]) => u32::from_le_bytes([*a, *b, *c, *d]),
            _ => 0,
        }
    }

    fn is_index(self) -> bool {
        matches!(self, Self::Unsigned8 | Self::Unsigned16 | Self::Unsigned32)
    }
}

/// Numbers of an element.
fn width(kind: &str) -> Option<usize> {
    Some(match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        _ => return None,
    })
}

/// Bytes of some elements: where they begin, and how far one is from the next.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Elements<'a> {
    fn get(&self, index: usize) -> &'a [u8] {
        let begin = index * self.stride;
        &self.bytes[begin..begin + self.size]
    }
}

impl Document {
    /// Numbers of an accessor whose elements have `wanted` numbers, one after the other.
    ///
    /// # Errors An accessor that is not there, has elements of another kind, or ends behind its buffer.
    pub fn floats(&self, index: usize, wanted: usize) -> Result<Vec<f32>, SceneError> {
        let (accessor, component) = self.accessor(index, wanted)?;
        if wanted > 4 && component != Component::Float {
            return Err(
                self.fault(format!("accessor {index} has matrices that are no floats: export it again"))
            );
        }
        self.read(index, wanted, |bytes| component.float(bytes, accessor.normalized))
    }

    /// Groups of `N` numbers of an accessor: see [`floats`](Self::floats).
    pub fn vectors<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>, SceneError> {
        let numbers = self.floats(index, N)?;
        Ok(numbers.chunks_exact(N).map(|vector| std::array::from_fn(|i| vector[i])).collect())
    }

    /// Whole numbers of an accessor: see [`floats`](Self::floats).
    pub fn whole_numbers(&self, index: usize, wanted: usize) -> Result<Vec<u32>, SceneError> {
        let (_, component) = self.accessor(index, wanted)?;
        if !component.is_index() {
            let message =
                format!("accessor {index} has indices that are no whole numbers from 0 on: export it again");
            return Err(self.fault(message));
        }
        self.read(index, wanted, |bytes| component.whole(bytes))
    }

    fn accessor(&self, index: usize, wanted: usize) -> Result<(&Accessor, Component), SceneError> {
        let accessor = self.get(&self.json.accessors, index, "accessor")?;
        let bad = |what: String| self.fault(format!("accessor {index} {what}: export the file again"));
        let code = accessor.component_type;
        let component =
            Component::of(code).ok_or_else(|| bad(format!("has the componentType {code}, which is none")))?;
        if width(&accessor.kind) != Some(wanted) {
            let kind: String = accessor.kind.chars().take(20).collect();
            return Err(bad(format!("is of type {kind}, and {wanted} numbers are needed")));
        }
        Ok((accessor, component))
    }

    fn read<T: Copy + Default>(
        &self,
        index: usize,
        width: usize,
        number: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, SceneError> {
        let (accessor, component) = self.accessor(index, width)?;
        let (count, size) = (accessor.count, component.size());
        let total = count.checked_mul(width).filter(|total| *total <= u32::MAX as usize);
        let total =
            total.ok_or_else(|| self.fault(format!("accessor {index} has too many elements: {count}")))?;
        let need = Need::new(Part::new("the geometry of the model", 4 * total as u64, "a smaller model"));
        need.check(&memory::left()).map_err(|error| self.fault(error.to_string()))?;
        let mut numbers = match accessor.buffer_view {
            Some(view) => {
                let elements = self.elements((index, view, accessor.byte_offset), count, size * width)?;
                let mut numbers = Vec::with_capacity(total);
                (0..count).for_each(|i| numbers.extend(elements.get(i).chunks_exact(size).map(&number)));
                numbers
            }
            None => vec![T::default(); total],
        };
        if let Some(sparse) = &accessor.sparse {
            let places = self.sparse_places(index, &sparse.indices, sparse.count)?;
            let SparsePart { buffer_view, byte_offset, .. } = sparse.values;
            let values = self.elements((index, buffer_view, byte_offset), sparse.count, size * width)?;
            for (i, place) in places.into_iter().enumerate() {
                let to = (place as usize).checked_mul(width).and_then(|at| numbers.get_mut(at..at + width));
                let to = to.ok_or_else(|| {
                    self.fault(format!(
                        "accessor {index} replaces element {place}, and has {count}: export it again"
                    ))
                })?;
                to.iter_mut()
                    .zip(values.get(i).chunks_exact(size))
                    .for_each(|(to, bytes)| *to = number(bytes));
            }
        }
        Ok(numbers)
    }

    fn sparse_places(&self, index: usize, part: &SparsePart, count: usize) -> Result<Vec<u32>, SceneError> {
        let component = part.component_type.and_then(Component::of).filter(|component| component.is_index());
        let component = component.ok_or_else(|| {
            self.fault(format!("accessor {index} is sparse without indices: export it again"))
        })?;
        let size = component.size();
        let elements = self.elements((index, part.buffer_view, part.byte_offset), count, size)?;
        Ok((0..count).map(|i| component.whole(elements.get(i))).collect())
    }

    /// The `count` elements of `size` bytes that accessor `index` has in a buffer view, from an offset on.
    fn elements(
        &self,
        (index, view, offset): (usize, usize, usize),
        count: usize,
        size: usize,
    ) -> Result<Elements<'_>, SceneError> {
        let (view, bytes) = self.view(view)?;
        let stride = view.byte_stride.filter(|stride| *stride > 0).unwrap_or(size);
        let length = match count.checked_sub(1) {
            None => Some(0),
            Some(before) => before.checked_mul(stride).and_then(|last| last.checked_add(size)),
        };
        let end = length.and_then(|length| offset.checked_add(length));
        let bytes = end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            let message = "ends behind its bufferView: the file is damaged; export it again";
            self.fault(format!("accessor {index} {message}"))
        })?;
        Ok(Elements { bytes, stride, size })
    }
}
