#include "server/app/runtime/recorder_settings.h"

#include <ctime>

namespace zoned::app {

namespace {

recording::RecordingHeader record_header(const config::Settings& settings) {
    recording::RecordingHeader header = recording::RecordingHeader::of_this_build();
    header.config_text = settings.text;
    header.config_digest = settings.digest;
    header.seed = settings.seed;
    return header;
}

}  // namespace

recording::RecorderSettings recorder_settings(const config::Settings& settings) {
    recording::RecorderSettings recorder;
    recorder.file = settings.server.recording_file;
    recorder.ring_folder = settings.server.session.state_folder + "/ring";
    recorder.ring_s = settings.server.ring_s;
    recorder.rate_hz = settings.tick_rate_hz;
    recorder.header = record_header(settings);
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

}  // namespace zoned::app
