#include "tests/bench/report/results_reader.h"

#include "tests/bench/report/json_fields.h"

#include <google/protobuf/util/json_util.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace zoned::bench {

namespace {

using google::protobuf::Struct;
using google::protobuf::Value;

double number_of(const Value& value) {
    return value.kind_case() == Value::kNumberValue ? value.number_value()
                                                    : std::numeric_limits<double>::quiet_NaN();
}

std::vector<std::string> texts_of(const Value& value) {
    std::vector<std::string> texts;
    for (const Value& text : value.list_value().values()) {
        texts.push_back(text.string_value());
    }
    return texts;
}

Row row_of(const Value& value) {
    Row row;
    json_text::for_each_field(
        value.struct_value(), [&row](const std::string& name, const Value& v) {
            if (name == "suite") {
                row.suite = v.string_value();
            } else if (name == "scene") {
                row.scene = v.string_value();
            } else if (name == "method") {
                row.method = v.string_value();
            } else if (name == "parameter") {
                row.parameter = v.string_value();
            } else if (name == "time_us_p50") {
                row.time_us_p50 = number_of(v);
            } else if (name == "time_us_p99") {
                row.time_us_p99 = number_of(v);
            } else if (name == "error") {
                row.error = number_of(v);
            } else if (name == "error_unit") {
                row.error_unit = v.string_value();
            } else if (name == "peer") {
                row.peer = v.string_value();
            } else if (name == "state_hash") {
                row.state_hash = v.string_value();
            } else if (name == "metrics") {
                json_text::for_each_field(v.struct_value(),
                                          [&row](const std::string& metric, const Value& m) {
                                              row.metric(metric, number_of(m));
                                          });
            }
        });
    return row;
}

SceneRun run_of(const Value& value) {
    SceneRun run;
    json_text::for_each_field(value.struct_value(),
                              [&run](const std::string& name, const Value& v) {
                                  if (name == "suite") {
                                      run.suite = v.string_value();
                                  } else if (name == "scene") {
                                      run.scene = v.string_value();
                                  } else if (name == "seconds") {
                                      run.seconds = number_of(v);
                                  } else if (name == "rows") {
                                      run.rows = static_cast<std::size_t>(v.number_value());
                                  } else if (name == "calibration_us") {
                                      run.calibration_us = number_of(v);
                                  }
                              });
    return run;
}

Drawing picture_of(const Value& value) {
    Drawing picture;
    json_text::for_each_field(value.struct_value(),
                              [&picture](const std::string& name, const Value& v) {
                                  std::string& text = name == "name"      ? picture.name
                                                      : name == "caption" ? picture.caption
                                                                          : picture.svg;
                                  text = v.string_value();
                              });
    return picture;
}

template <class T>
std::vector<T> list_of(const Value& value, T (*read)(const Value&)) {
    std::vector<T> out;
    for (const Value& element : value.list_value().values()) {
        out.push_back(read(element));
    }
    return out;
}

}  // namespace

Results results_from_json(const std::string& text, const std::string& source) {
    Struct top;
    const auto status = google::protobuf::util::JsonStringToMessage(text, &top);
    if (!status.ok()) {
        throw std::runtime_error(source + " holds no JSON of zoned-bench");
    }
    Results results;
    bool has_rows = false;
    json_text::for_each_field(top, [&](const std::string& name, const Value& v) {
        if (name == "machine") {
            results.machine = v.string_value();
        } else if (name == "commit") {
            results.commit = v.string_value();
        } else if (name == "build") {
            results.build = v.string_value();
        } else if (name == "flags") {
            results.flags = v.string_value();
        } else if (name == "quick") {
            results.quick = v.bool_value();
        } else if (name == "repeats") {
            results.repeats = static_cast<int>(v.number_value());
        } else if (name == "methods") {
            results.methods = texts_of(v);
        } else if (name == "notes") {
            results.notes = texts_of(v);
        } else if (name == "runs") {
            results.runs = list_of(v, run_of);
        } else if (name == "rows") {
            results.rows = list_of(v, row_of);
            has_rows = v.kind_case() == Value::kListValue;
        } else if (name == "pictures") {
            results.pictures = list_of(v, picture_of);
        }
    });
    if (!has_rows) {
        throw std::runtime_error(source + " holds no rows of zoned-bench");
    }
    return results;
}

std::string read_text_file(const std::string& path) {
    const std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    if (!in || !text) {
        throw std::runtime_error("can't read " + path);
    }
    return text.str();
}

void write_text_file(const std::string& path, const std::string& text) {
    std::error_code refused;
    std::filesystem::create_directories(std::filesystem::absolute(path).parent_path(), refused);
    const std::string next = path + ".new";
    std::ofstream out(next, std::ios::binary);
    out << text;
    out.close();
    if (!out || std::rename(next.c_str(), path.c_str()) != 0) {
        std::remove(next.c_str());
        throw std::runtime_error("can't write " + path);
    }
}

}  // namespace zoned::bench
