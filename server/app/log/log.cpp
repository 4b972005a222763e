#include "server/app/log/log.h"

#include "shared/core/json.h"
#include "shared/core/token_bucket.h"

#include <spdlog/async_logger.h>
#include <spdlog/details/fmt_helper.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

namespace zoned::app {

namespace {

using spdlog::level::level_enum;

constexpr std::size_t kQueuedLines = 8192;
constexpr auto kDrainPatience = std::chrono::seconds(1);

constexpr std::array<std::pair<const char*, level_enum>, 4> kLevels{
    {{"debug", spdlog::level::debug},
     {"info", spdlog::level::info},
     {"warning", spdlog::level::warn},
     {"error", spdlog::level::err}}};

level_enum level_of(config::LogLevel level) {
    return kLevels[static_cast<std::size_t>(level)].second;
}

const char* level_name(level_enum level) {
    for (const auto& [name, value] : kLevels) {
        if (value == level) {
            return name;
        }
    }
    return "off";
}

void append(spdlog::memory_buf_t& out, std::string_view text) {
    out.append(text.data(), text.data() + text.size());
}

/// {"time":"2026-01-31T12:00:00.123Z","level":"info","area":"session","message":"..."}
class JsonLineFormatter final : public spdlog::formatter {
  public:
    void format(const spdlog::details::log_msg& msg, spdlog::memory_buf_t& out) override {
        append(out, "{\"time\":\"");
        time_.format(msg, out);
        append(out, "\",\"level\":\"");
        append(out, level_name(msg.level));
        append(out, "\",\"area\":");
        append(out, core::json_quote({msg.logger_name.data(), msg.logger_name.size()}));
        append(out, ",\"message\":");
        append(out, core::json_quote({msg.payload.data(), msg.payload.size()}));
        append(out, "}\n");
    }

    [[nodiscard]] std::unique_ptr<spdlog::formatter> clone() const override {
        return std::make_unique<JsonLineFormatter>();
    }

  private:
    spdlog::pattern_formatter time_{"%Y-%m-%dT%H:%M:%S.%eZ", spdlog::pattern_time_type::utc, ""};
};

std::atomic<std::uint64_t>& lines_left_out() {
    static std::atomic<std::uint64_t> count{0};
    return count;
}

/// Counts flushes that came through the queue: all lines before them are written.
std::atomic<std::uint64_t>& flushes_done() {
    static std::atomic<std::uint64_t> count{0};
    return count;
}

/// Passes on so many lines of each area a second, warnings and errors counted apart: a flood of one
/// kind hides no other. Tells how many it left out. Called by the log's thread alone.
class LimitedSink final : public spdlog::sinks::sink {
  public:
    LimitedSink(std::shared_ptr<spdlog::sinks::sink> to, double lines_per_s) : to_(std::move(to)) {
        for (Limit& limit : limits_) {
            limit.bucket = core::TokenBucket(lines_per_s, 2.0 * lines_per_s);
        }
    }

    void log(const spdlog::details::log_msg& msg) override {
        const double now_s = std::chrono::duration<double>(msg.time.time_since_epoch()).count();
        const std::size_t area =
            config::find_log_area(std::string_view(msg.logger_name.data(), msg.logger_name.size()));
        Limit& limit = limits_[2 * area + (msg.level >= spdlog::level::warn ? 1 : 0)];
        if (!limit.bucket.take(now_s)) {
            ++limit.left_out;
            ++lines_left_out();
            return;
        }
        if (limit.left_out > 0) {
            const std::string text =
                std::to_string(limit.left_out) + " lines were left out: more than log.lines_per_s";
            limit.left_out = 0;
            to_->log({msg.time, {}, msg.logger_name, spdlog::level::warn, text});
        }
        to_->log(msg);
    }

    void flush() override {
        to_->flush();
        ++flushes_done();
    }

    void set_pattern(const std::string& pattern) override { to_->set_pattern(pattern); }

    void set_formatter(std::unique_ptr<spdlog::formatter> formatter) override {
        to_->set_formatter(std::move(formatter));
    }

  private:
    struct Limit {
        core::TokenBucket bucket{1.0, 1.0};
        std::uint64_t left_out = 0;
    };

    std::shared_ptr<spdlog::sinks::sink> to_;
    std::array<Limit, 2 * (config::kLogAreas + 1)> limits_;
};

struct LogState {
    std::shared_ptr<spdlog::details::thread_pool> pool;
    std::array<std::shared_ptr<spdlog::async_logger>, config::kLogAreas> loggers;
};

LogState& log_state() {
    static LogState state;
    return state;
}

}  // namespace

Log::Log(const config::LogSettings& settings, std::ostream* out) {
    std::shared_ptr<spdlog::sinks::sink> sink;
    if (out != nullptr) {
        sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(*out, true);
    } else {
        sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
    }
    if (settings.json) {
        sink->set_formatter(std::make_unique<JsonLineFormatter>());
    } else {
        sink->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %n: %v");
    }
    const auto limited = std::make_shared<LimitedSink>(std::move(sink), settings.lines_per_s);
    LogState& state = log_state();
    state.pool = std::make_shared<spdlog::details::thread_pool>(kQueuedLines, 1);
    for (std::size_t a = 0; a < config::kLogAreas; ++a) {
        state.loggers[a] =
            std::make_shared<spdlog::async_logger>(std::string(config::kLogAreaNames[a]),
                                                   limited,
                                                   state.pool,
                                                   spdlog::async_overflow_policy::overrun_oldest);
    }
    set_levels(settings);
    spdlog::set_default_logger(state.loggers[static_cast<std::size_t>(LogArea::kServer)]);
}

Log::~Log() {
    LogState& state = log_state();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "zoned", std::make_shared<spdlog::sinks::stderr_color_sink_mt>()));
    // The queue is written when its thread is joined. That thread is the last to use loggers and
    // sinks.
    state.pool = nullptr;
    state.loggers.fill(nullptr);
}

void Log::set_levels(const config::LogSettings& settings) {
    for (std::size_t a = 0; a < config::kLogAreas; ++a) {
        if (const auto& logger = log_state().loggers[a]) {
            logger->set_level(level_of(settings.levels[a]));
        }
    }
}

void Log::drain() {
    const std::uint64_t before = flushes_done().load();
    const auto end = std::chrono::steady_clock::now() + kDrainPatience;
    log_of(LogArea::kServer).flush();
    while (flushes_done().load() == before && std::chrono::steady_clock::now() < end) {
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
}

LogCounts Log::counts() {
    const auto& pool = log_state().pool;
    return {lines_left_out().load(), pool ? pool->overrun_counter() : 0};
}

spdlog::logger& log_of(LogArea area) {
    const auto& logger = log_state().loggers[static_cast<std::size_t>(area)];
    return logger ? *logger : *spdlog::default_logger_raw();
}

std::string log_level_of(LogArea area) {
    return level_name(log_of(area).level());
}

std::string log_level() {
    const std::string first = log_level_of(LogArea::kServer);
    for (std::size_t a = 1; a < config::kLogAreas; ++a) {
        if (log_level_of(static_cast<LogArea>(a)) != first) {
            return "mixed";
        }
    }
    return first;
}

bool set_log_level(LogArea area, const std::string& level) {
    for (const auto& [name, value] : kLevels) {
        if (level != name) {
            continue;
        }
        for (std::size_t a = 0; a < config::kLogAreas; ++a) {
            if (area == LogArea::kCount || area == static_cast<LogArea>(a)) {
                log_of(static_cast<LogArea>(a)).set_level(value);
            }
        }
        return true;
    }
    return false;
}

}  // namespace zoned::app
