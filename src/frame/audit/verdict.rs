//! Verdicts of checks.

/// Result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    Holds,
    OnEdge,
    Differs,
}

impl Verdict {
    /// `Holds` if `holds`, else `Differs`.
    pub fn new(holds: bool) -> Self {
        if holds { Verdict::Holds } else { Verdict::Differs }
    }

    /// Replaces a failure by the verdict of another check, if that `may` count.
    pub fn or_if(self, may: bool, other: impl FnOnce() -> Self) -> Self {
        if self == Verdict::Differs && may { other() } else { self }
    }

    /// Replaces a failure by `OnEdge`, if the sample holds on an edge.
    pub fn or_on_edge(self, on_edge: impl FnOnce() -> bool) -> Self {
        if self == Verdict::Differs && on_edge() { Verdict::OnEdge } else { self }
    }
}
