//! Laws whose bodies are somebody else's code.

/// What the system has to know of a law that was compiled elsewhere: it may fail, and it may have a memory.
pub(crate) trait Foreign: Send + Sync {
    /// Why the law no longer runs.
    fn failure(&self) -> Option<String>;
    /// What it remembers from call to call.
    fn save(&self) -> Result<Vec<u8>, String>;
    /// Makes it remember this.
    fn load(&self, memory: &[u8]) -> Result<(), String>;
}
