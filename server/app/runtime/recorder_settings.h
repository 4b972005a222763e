// Recorder settings: what a server records by its config, or from now on, and where.
#pragma once

#include "server/app/runtime/visited_world.h"
#include "server/config/settings.h"
#include "server/recording/recorder.h"

#include <string>

namespace zoned::app {

/// The recording of the whole run and the last inputs, as the config asks for them. Where the world
/// goes on after the death of a server, the file begins with its state, and the tick stands in its
/// name: the recording of the dead server stays.
recording::RecorderSettings recorder_settings(const config::Settings& settings, const World& world);

/// A file of the state folder; without a name the time is one.
std::string recording_path(const config::Settings& settings, const std::string& name);

/// Begins a file with the state that the world has after one of the next ticks. That tick is as
/// much longer as the state takes to write: 40 ms where 200 players are in valley. Fails where the
/// world has a part without a saved form. Both outlive the answer.
void record_from_now(VisitedWorld& world,
                     recording::Recorder& recorder,
                     const std::string& file,
                     const recording::RecordingAnswer& answer);

}  // namespace zoned::app
