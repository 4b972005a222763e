#include "tests/bench/results.h"
#include "shared/core/json.h"

namespace zoned::bench {

void Row::metric(std::string name, double value) {
    metrics.emplace_back(std::move(name), value);
}

const double* Row::find_metric(const std::string& name) const {
    for (const auto& [key, value] : metrics) {
        if (key == name) {
            return &value;
        }
    }
    return nullptr;
}

namespace {

void write_row(core::JsonWriter& json, const Row& row) {
    json.begin_object();
    json.field("suite", row.suite).field("scene", row.scene);
    json.field("method", row.method).field("parameter", row.parameter);
    json.field("time_us_p50", row.time_us_p50).field("time_us_p99", row.time_us_p99);
    json.field("error", row.error).field("error_unit", row.error_unit);
    json.key("metrics").begin_object();
    for (const auto& [name, value] : row.metrics) {
        json.field(name, value);
    }
    json.end_object();
    json.field("peer", row.peer).field("state_hash", row.state_hash);
    json.end_object();
}

void write_run(core::JsonWriter& json, const SceneRun& run) {
    json.begin_object();
    json.field("suite", run.suite).field("scene", run.scene);
    json.field("seconds", run.seconds).field("rows", run.rows);
    json.field("calibration_us", run.calibration_us);
    json.end_object();
}

void write_texts(core::JsonWriter& json, const char* name, const std::vector<std::string>& texts) {
    json.key(name).begin_array();
    for (const std::string& text : texts) {
        json.value(text);
    }
    json.end_array();
}

}  // namespace

std::string to_json(const Results& results, Pictures pictures) {
    core::JsonWriter json;
    json.begin_object();
    json.field("machine", results.machine).field("commit", results.commit);
    json.field("build", results.build).field("flags", results.flags);
    json.field("quick", results.quick).field("repeats", results.repeats);
    write_texts(json, "methods", results.methods);
    write_texts(json, "notes", results.notes);
    json.key("runs").begin_array();
    for (const SceneRun& run : results.runs) {
        write_run(json, run);
    }
    json.end_array();
    json.key("rows").begin_array();
    for (const Row& row : results.rows) {
        write_row(json, row);
    }
    json.end_array();
    if (pictures == Pictures::kKeep) {
        json.key("pictures").begin_array();
        for (const Drawing& picture : results.pictures) {
            json.begin_object();
            json.field("name", picture.name).field("caption", picture.caption);
            json.field("svg", picture.svg);
            json.end_object();
        }
        json.end_array();
    }
    json.end_object();
    return json.text() + "\n";
}

}  // namespace zoned::bench
