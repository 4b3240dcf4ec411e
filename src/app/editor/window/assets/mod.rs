//! Reads the folder that the browser of assets shows, and makes the pictures of the files in sight, one after the other
//! on a thread of low priority.

mod file_picture;
mod lamp_picture;
mod listing;
mod places;
mod volume_picture;

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use crossbeam_channel::{Receiver, TryRecvError, bounded};

use super::widgets::Widgets;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::model::EditorModel;
use crate::app::editor::model::assets::{AssetEntry, AssetPicture, AssetPlace, Listing};
use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::session::picture_cache::PictureCache;
use crate::engine::{WakeUp, yield_to_all};
use crate::files::Access;
use crate::scene::{SceneStatus, Trust};
use file_picture::{Content, content_of};

/// The time after which a folder is read again.
const AGE: Duration = Duration::from_secs(2);
/// The number of pictures that are kept although they are no longer visible.
const MOST: usize = 256;

/// The work for the panel, and its results.
#[derive(Resource, Default)]
pub(crate) struct AssetWork {
    /// The folder that is being read.
    listing: Option<(PathBuf, Receiver<Listing>)>,
    listed: Option<(Arc<Listing>, Instant)>,
    content: Option<(AssetEntry, Receiver<Result<Content, String>>)>,
    made: HashMap<PathBuf, Made>,
}

/// The result for a file of this length and time.
struct Made {
    of: AssetEntry,
    picture: AssetPicture,
    /// Keeps the texture alive.
    _texture: Option<egui::TextureHandle>,
}

/// Starts the next work, and hands the results to the panel.
pub(crate) fn update_assets(
    mut work: ResMut<AssetWork>,
    mut model: ResMut<EditorModel>,
    mut contexts: EguiContexts,
    mut widgets: ResMut<Widgets>,
    preferences: Res<Preferences>,
    status: Res<SceneStatus>,
    cache: Res<PictureCache>,
    wake_up: Res<WakeUp>,
    pacing: Res<Pacing>,
    trust: Option<Res<Trust>>,
) -> Result {
    let assets = &mut model.0.assets;
    if assets.places.is_empty() || preferences.is_changed() || status.is_changed() {
        let places = places::places(status.path.as_deref(), &preferences);
        if *assets.places != places {
            let is_new = |place: &&AssetPlace| place.is_own && !assets.places.contains(place);
            let added = places.iter().find(is_new).filter(|_| !assets.places.is_empty());
            if let Some(added) = added {
                widgets.assets.folder = Some(added.folder.clone());
            }
            assets.places = Arc::new(places);
        }
        if assets.environments.is_empty() {
            assets.environments = Arc::new(places::environments());
        }
    }
    let shelf = &mut widgets.assets;
    if !shelf.is_shown {
        return Ok(());
    }
    if shelf.folder.is_none() {
        shelf.folder = assets.places.first().map(|place| place.folder.clone());
    }
    let mut is_new = shelf.folder.as_ref().is_some_and(|folder| work.list(folder, &wake_up));
    let listed = work.listed.as_ref().map(|(listing, _)| listing);
    assets.listing = listed
        .filter(|listing| Some(&listing.folder) == shelf.folder.as_ref())
        .cloned();
    is_new |= work.take_content(contexts.ctx_mut()?);
    if work.content.is_none() && pacing.rests() {
        let next = shelf.in_sight.iter().find(|entry| !work.has(entry));
        if let Some(entry) = next {
            let mut trusted = trust
                .map_or_else(Trust::default, |trust| trust.clone())
                .access(&entry.path);
            let own = assets.places.iter().filter(|place| place.is_own);
            own.for_each(|place| trusted.allow(&place.folder));
            work.content = look_into(entry.clone(), cache.clone(), trusted, wake_up.clone());
        }
    }
    if work.made.len() > MOST {
        let in_sight: Vec<&PathBuf> = shelf.in_sight.iter().map(|entry| &entry.path).collect();
        work.made.retain(|path, _| in_sight.contains(&path));
        is_new = true;
    }
    if is_new {
        let pictures = work.made.iter();
        assets.pictures = Arc::new(
            pictures
                .map(|(path, made)| (path.clone(), made.picture.clone()))
                .collect(),
        );
    }
    Ok(())
}

impl AssetWork {
    fn has(&self, entry: &AssetEntry) -> bool {
        self.made.get(&entry.path).is_some_and(|made| made.of == *entry)
    }

    /// Takes the requested listing, and requests one of the folder if there is none or an old one. Returns true if the
    /// errors of another folder's files are dropped: their reason may have passed on return.
    fn list(&mut self, folder: &PathBuf, wake_up: &WakeUp) -> bool {
        let mut forgets = false;
        // A folder that is slow to read must not keep others waiting.
        let asked = self.listing.take().filter(|(asked, _)| asked == folder);
        match asked.map(|(asked, receiver)| (receiver.try_recv(), asked, receiver)) {
            Some((Err(TryRecvError::Empty), asked, receiver)) => {
                self.listing = Some((asked, receiver));
                return false;
            }
            Some((Ok(listing), ..)) => {
                let before = self.listed.take().map(|(known, _)| known);
                forgets = before.as_ref().is_some_and(|known| known.folder != listing.folder);
                let known = before.filter(|known| **known == listing);
                self.listed = Some((known.unwrap_or_else(|| Arc::new(listing)), Instant::now()));
            }
            Some((Err(TryRecvError::Disconnected), ..)) | None => {}
        }
        if forgets {
            self.made.retain(|_, made| made.picture.problem.is_none());
        }
        let is_fresh = |(listing, since): &(Arc<Listing>, Instant)| listing.folder == *folder && since.elapsed() < AGE;
        if !self.listed.as_ref().is_some_and(is_fresh) {
            let asked = folder.clone();
            let receiver = on_thread("listing", wake_up.clone(), move || listing::list(&asked));
            self.listing = receiver.map(|receiver| (folder.clone(), receiver));
        }
        forgets
    }

    /// Takes the content of a file from its thread; returns true if there was any.
    fn take_content(&mut self, context: &egui::Context) -> bool {
        let Some((entry, content)) = &self.content else {
            return false;
        };
        let content = match content.try_recv() {
            Err(TryRecvError::Empty) => return false,
            // The thread has ended without an answer.
            Err(TryRecvError::Disconnected) => Err("it cannot be read".to_owned()),
            Ok(content) => content,
        };
        let entry = entry.clone();
        self.content = None;
        let made = match content {
            Ok(content) => {
                let size = content.image.as_ref().map_or([0; 2], |image| image.size);
                let name = || entry.path.to_string_lossy().into_owned();
                let options = egui::TextureOptions::LINEAR;
                let texture = content.image.map(|image| context.load_texture(name(), image, options));
                let picture = AssetPicture {
                    texture: texture.as_ref().map(egui::TextureHandle::id),
                    size,
                    note: content.note,
                    bounds: content.bounds,
                    is_material: content.is_material,
                    problem: None,
                };
                (picture, texture)
            }
            Err(problem) => {
                let problem = Some(problem);
                (
                    AssetPicture {
                        problem,
                        ..AssetPicture::default()
                    },
                    None,
                )
            }
        };
        let (picture, texture) = made;
        self.made.insert(
            entry.path.clone(),
            Made {
                of: entry,
                picture,
                _texture: texture,
            },
        );
        true
    }
}

fn look_into(
    entry: AssetEntry,
    cache: PictureCache,
    trusted: Access,
    wake_up: WakeUp,
) -> Option<(AssetEntry, Receiver<Result<Content, String>>)> {
    let file = entry.clone();
    let receiver = on_thread("thumbnail", wake_up, move || content_of(&file, &cache, &trusted))?;
    Some((entry, receiver))
}

/// Runs an act on a thread of the lowest priority.
fn on_thread<T: Send + 'static>(
    name: &str,
    wake_up: WakeUp,
    act: impl FnOnce() -> T + Send + 'static,
) -> Option<Receiver<T>> {
    let (sender, receiver) = bounded(1);
    let work = move || {
        yield_to_all();
        // The receiver is gone if the window closes.
        let _ = sender.send(act());
        if let Some(wake) = &wake_up.0 {
            wake();
        }
    };
    match std::thread::Builder::new().name(name.to_owned()).spawn(work) {
        Ok(_) => Some(receiver),
        Err(error) => {
            error!("A thread for the browser of assets could not be started: {error}");
            None
        }
    }
}
