//! Who wants to know how far a frame is.

use std::sync::Arc;

/// Is told, while a frame is made, how many tiles more are done. Whatever it does, rendering waits for it.
pub type Watcher = Arc<dyn Fn(usize) + Send + Sync>;
