#include "server/app/runtime/recorder_settings.h"

#include "server/app/log/log.h"

#include <ctime>
#include <filesystem>
#include <utility>

namespace zoned::app {

namespace {

recording::RecordingHeader record_header(const config::Settings& settings) {
    recording::RecordingHeader header = recording::RecordingHeader::of_this_build();
    header.config_text = settings.text;
    header.config_digest = settings.digest;
    header.seed = settings.seed;
    return header;
}

void go_on_recording(recording::RecorderSettings& recorder, const World& world) {
    recorder.begins.tick = world.now();
    const std::string wrong = world.save(recorder.begins.bytes);
    if (!wrong.empty()) {
        log_of(LogArea::kServer).error("recording.file: nothing is recorded: {}", wrong);
        recorder.file.clear();
        return;
    }
    recorder.file = std::filesystem::path(recorder.file)
                        .replace_extension(std::to_string(world.now()) + ".zrec");
    log_of(LogArea::kServer)
        .info("recording.file: from tick {} on in {}", world.now() + 1, recorder.file);
}

}  // namespace

recording::RecorderSettings recorder_settings(const config::Settings& settings,
                                              const World& world) {
    recording::RecorderSettings recorder;
    recorder.file = settings.server.recording_file;
    recorder.ring_folder = settings.server.session.state_folder + "/ring";
    recorder.ring_s = settings.server.ring_s;
    recorder.rate_hz = settings.tick_rate_hz;
    recorder.header = record_header(settings);
    if (world.now() > 0 && !recorder.file.empty()) {
        go_on_recording(recorder, world);
    }
    return recorder;
}

std::string recording_path(const config::Settings& settings, const std::string& name) {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char time[32];
    std::strftime(time, sizeof(time), "%Y%m%dT%H%M%S.zrec", &parts);
    return settings.server.session.state_folder + "/recordings/" + (name.empty() ? time : name);
}

void record_from_now(VisitedWorld& world,
                     recording::Recorder& recorder,
                     const std::string& file,
                     const recording::RecordingAnswer& answer) {
    using Answer = core::Result<std::string>;
    const bool waits = world.visit([&recorder, file, answer](const World& now) {
        recording::RecordedState state{now.now(), {}};
        const std::string wrong = now.save(state.bytes);
        if (wrong.empty()) {
            recorder.start_file(file, std::move(state), answer);
        } else {
            answer(Answer::failure("this world cannot begin a recording while it runs: " + wrong));
        }
    });
    if (!waits) {
        answer(Answer::failure("too many ask for the world at once: try again"));
    }
}

}  // namespace zoned::app
