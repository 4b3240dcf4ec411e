//! Environment pictures with their sampling densities, which take a while to build: they are kept while they are in
//! use.

use std::sync::Arc;

use crate::light::EnvironmentMap;
use crate::memory::{Held, Shortage};
use crate::texture::Image;

#[derive(Default)]
pub(in crate::engine) struct Environments(Vec<Known>);

struct Known {
    image: Arc<Image>,
    compensated: bool,
    map: Arc<EnvironmentMap>,
    in_use: bool,
    /// The memory reserved for the density.
    _memory: Held,
}

impl Environments {
    pub fn begin_use(&mut self) {
        self.0.iter_mut().for_each(|known| known.in_use = false);
    }

    /// The same map for each request of a picture. An error if its density does not fit into the memory budget.
    pub fn get(&mut self, image: &Arc<Image>, compensated: bool) -> Result<Arc<EnvironmentMap>, Shortage> {
        let is_it = |known: &&mut Known| Arc::ptr_eq(&known.image, image) && known.compensated == compensated;
        if let Some(known) = self.0.iter_mut().find(is_it) {
            known.in_use = true;
            return Ok(known.map.clone());
        }
        let memory = image.reserve_environment()?;
        let map = Arc::new(EnvironmentMap::new(image.clone(), compensated));
        self.0.push(Known {
            image: image.clone(),
            compensated,
            map: map.clone(),
            in_use: true,
            _memory: memory,
        });
        Ok(map)
    }

    /// Removes the environments that were not requested since [`Self::begin_use`], unless they are still in use
    /// elsewhere.
    pub fn end_use(&mut self) {
        self.0.retain(|known| known.in_use || Arc::strong_count(&known.map) > 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_density_lives_as_long_as_it_is_used() {
        let (grey, white) = (Arc::new(Image::uniform(0.5)), Arc::new(Image::uniform(1.0)));
        let mut all = Environments::default();
        let get = |all: &mut Environments, image, compensated| all.get(image, compensated).expect("there is room");
        all.begin_use();
        let first = get(&mut all, &grey, true);
        assert!(Arc::ptr_eq(&first, &get(&mut all, &grey, true)));
        assert!(!Arc::ptr_eq(&first, &get(&mut all, &grey, false)));
        assert!(!Arc::ptr_eq(&first, &get(&mut all, &white, true)));
        all.end_use();
        all.begin_use();
        assert!(Arc::ptr_eq(&first, &get(&mut all, &grey, true)));
        all.end_use();
        assert_eq!(all.0.len(), 1);
    }
}
