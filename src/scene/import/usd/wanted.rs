//! What is asked of a file.

use super::choice::{StageChoice, ViewChoice};

/// What is to be read of a file.
#[derive(Clone)]
pub struct Wanted {
    pub choice: StageChoice,
    /// Of a file that is a shot: what is chosen for its picture. Its settings count.
    pub view: Option<ViewChoice>,
}
