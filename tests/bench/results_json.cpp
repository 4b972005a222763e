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

}  // namespace

std::string to_json(const Results& results) {
    core::JsonWriter json;
    json.begin_object();
    json.field("machine", results.machine).field("commit", results.commit);
    json.field("build", results.build).field("quick", results.quick);
    json.key("notes").begin_array();
    for (const std::string& note : results.notes) {
        json.value(note);
    }
    json.end_array();
    json.key("rows").begin_array();
    for (const Row& row : results.rows) {
        write_row(json, row);
    }
    json.end_array();
    json.end_object();
    return json.text() + "\n";
}

}  // namespace zoned::bench
