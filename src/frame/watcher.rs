//! Who wants to know how far a frame is, and who may want no more of it.

use std::sync::Arc;

/// Is told, while a frame is made, how many tiles more are done. Whatever it does, rendering waits for it.
pub type Watcher = Arc<dyn Fn(usize) + Send + Sync>;

/// Is asked, while a frame is made, whether nobody wants it any more: after each band of tiles. Rendering waits for the answer.
pub type Stop = Arc<dyn Fn() -> bool + Send + Sync>;
