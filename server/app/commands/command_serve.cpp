#include "server/app/calibration/measure_codec.h"
#include "server/app/calibration/particle_device.h"
#include "server/app/commands/commands.h"
#include "server/app/commands/config_loading.h"
#include "server/app/commands/serve_report.h"
#include "server/app/runtime/host_settings.h"
#include "server/app/runtime/network.h"
#include "server/app/runtime/tick_loop.h"
#include "server/app/world/agent_reload.h"
#include "server/app/world/world.h"
#include "server/config/expand/stability_report.h"

#include <asio/post.hpp>
#include <asio/signal_set.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <thread>

namespace zoned::app {

namespace {

constexpr auto kFarewell = std::chrono::seconds(2);
constexpr auto kStatusEvery = std::chrono::seconds(10);

unsigned thread_count(const config::Settings& settings) {
    const unsigned asked = settings.server.run.threads;
    const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
    const auto zones = static_cast<unsigned>(settings.zones.size());
    return asked > 0 ? asked : std::min(cores, zones);
}

void set_up_log(const config::Settings& settings) {
    static constexpr spdlog::level::level_enum kLevels[] = {
        spdlog::level::debug, spdlog::level::info, spdlog::level::warn, spdlog::level::err};
    auto logger = spdlog::get("zoned");
    if (!logger) {
        logger = spdlog::stderr_color_mt("zoned");
    }
    spdlog::set_default_logger(logger);
    spdlog::set_level(kLevels[static_cast<std::size_t>(settings.server.run.log_level)]);
}

recording::RecordingHeader record_header(const config::Settings& settings) {
    recording::RecordingHeader header = recording::RecordingHeader::of_this_build();
    header.config_text = settings.text;
    header.config_digest = settings.digest;
    header.seed = settings.seed;
    return header;
}

/// One run of the server: world, loop, network, signals; all wiring and nothing else.
class Server {
  public:
    Server(const ServeArguments& arguments, const config::Settings& settings)
        : arguments_(arguments),
          settings_(settings),
          signals_(io_, SIGINT, SIGTERM),
          reload_signal_(io_, SIGHUP),
          stop_timer_(io_),
          status_timer_(io_),
          world_(settings, thread_count(settings), &thread_cpu_ns),
          network_(io_, settings, [this](mailbox::InboxItem item) {
              loop_->post(std::move(item));
          }) {
        open_recording();
        open_device();
        LoopSettings loop;
        loop.rate_hz = settings.tick_rate_hz;
        loop.max_catch_up = settings.server.run.max_catch_up_ticks;
        loop.mailbox_capacity = settings.server.run.mailbox_capacity * settings.zones.size();
        loop_ = std::make_unique<TickLoop>(
            world_,
            loop,
            [this](TickResult result) {
                asio::post(io_, [this, moved = std::make_shared<TickResult>(std::move(result))] {
                    network_.deliver(std::move(*moved));
                });
            },
            recorder_.get());
        if (settings.replication.codec == replication::Codec::kAuto) {
            loop_->post(price_of_coding());
        }
    }

    int run() {
        const double begin = steady_seconds();
        signals_.async_wait([this](const asio::error_code& error, int signal) {
            if (!error) {
                stop(signal == SIGINT ? "interrupted" : "asked to stop");
            }
        });
        await_reload();
        if (arguments_.seconds > 0.0) {
            stop_timer_.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(
                std::chrono::duration<double>(arguments_.seconds)));
            stop_timer_.async_wait([this](const asio::error_code& error) {
                if (!error) {
                    stop("its time is over");
                }
            });
        }
        network_.start();
        loop_->start();
        announce();
        if (settings_.replication.meter) {
            log_status();
        }
        io_.run();
        return finish(steady_seconds() - begin);
    }

  private:
    static mailbox::CodecPrice price_of_coding() {
        const mailbox::CodecPrice price = measure_codec();
        spdlog::info("coding for one client: {} ns a record and {} ns a packet",
                     price.record_ns,
                     price.packet_ns);
        return price;
    }

    void await_reload() {
        reload_signal_.async_wait([this](const asio::error_code& error, int) {
            if (!error) {
                reload();
                await_reload();
            }
        });
    }

    /// Reads the config on a thread of its own: sockets are served meanwhile.
    void reload() {
        if (reloading_) {
            spdlog::warn("the config is being read already");
            return;
        }
        reloading_ = true;
        if (reader_.joinable()) {
            reader_.join();
        }
        reader_ = std::thread([this] {
            auto brains = std::make_shared<core::Result<mailbox::NewBrains>>(
                load_brains(arguments_.config, arguments_.sets, settings_));
            asio::post(io_, [this, brains] {
                reloading_ = false;
                if (!brains->ok()) {
                    spdlog::error("{} is not taken, everything stays as it was: {}",
                                  arguments_.config,
                                  brains->error());
                } else if (loop_->post(**brains)) {
                    spdlog::info("brains are as {} says now", arguments_.config);
                } else {
                    spdlog::error("no room for new brains in the mailbox: try again");
                }
            });
        });
    }

    void open_recording() {
        const std::string& file = settings_.server.recording_file;
        if (file.empty()) {
            return;
        }
        recorder_ = std::make_unique<recording::RecordingWriter>();
        const auto opened = recorder_->open(file, record_header(settings_));
        if (!opened.ok()) {
            throw std::runtime_error(opened.error());
        }
    }

    void open_device() {
        particle_device_ = open_particle_device(settings_, world_.pool().threads());
        if (!settings_.particles.empty()) {
            spdlog::log(particle_device_.failed ? spdlog::level::warn : spdlog::level::info,
                        "{}",
                        particle_device_.text);
        }
        if (!particle_device_.no_cache.empty()) {
            spdlog::warn("{}", particle_device_.no_cache);
        }
        if (particle_device_.device) {
            world_.use_device(particle_device_.device.get(), particle_device_.crossover);
        }
    }

    void announce() {
        spdlog::info("world {}: {} zones, {} entities, {} threads, certificate sha256 {}",
                     settings_.world_name,
                     settings_.zones.size(),
                     settings_.initial.size(),
                     world_.pool().threads(),
                     network_.fingerprint());
        std::printf("ready tcp=%u udp=%u admin=%u zones=%zu\n",
                    static_cast<unsigned>(network_.tcp_port()),
                    static_cast<unsigned>(network_.udp_port()),
                    0U,
                    settings_.zones.size());
        std::fflush(stdout);
    }

    void log_status() {
        status_timer_.expires_after(kStatusEvery);
        status_timer_.async_wait([this](const asio::error_code& error) {
            if (!error) {
                log_traffic({settings_, *loop_, network_, 1, 0.0},
                            logged_traffic_,
                            std::chrono::duration<double>(kStatusEvery).count());
                log_status();
            }
        });
    }

    /// First the clients hear why, then the sockets close; a second signal does not wait.
    void stop(const std::string& why) {
        spdlog::info("stopping: {}", why);
        stop_timer_.cancel();
        status_timer_.cancel();
        network_.shutdown("the server closes: " + why);
        farewell_end_ = std::chrono::steady_clock::now() + kFarewell;
        signals_.async_wait([this](const asio::error_code& error, int) {
            if (!error) {
                farewell_end_ = std::chrono::steady_clock::now();
            }
        });
        say_farewell();
    }

    void say_farewell() {
        if (network_.connections() == 0 || std::chrono::steady_clock::now() >= farewell_end_) {
            loop_->stop();
            network_.close();
            signals_.cancel();
            reload_signal_.cancel();
            return;
        }
        stop_timer_.expires_after(std::chrono::milliseconds(20));
        stop_timer_.async_wait([this](const asio::error_code& error) {
            if (!error) {
                say_farewell();
            }
        });
    }

    int finish(double seconds) {
        if (reader_.joinable()) {
            reader_.join();
        }
        if (recorder_) {
            const auto closed = recorder_->close();
            if (!closed.ok()) {
                throw std::runtime_error(closed.error());
            }
        }
        const ServeFigures figures{settings_, *loop_, network_, world_.pool().threads(), seconds};
        log_summary(figures);
        if (!arguments_.report.empty()) {
            write_serve_report(arguments_.report, figures);
        }
        return kGood;
    }

    ServeArguments arguments_;
    const config::Settings& settings_;
    asio::io_context io_;
    asio::signal_set signals_;
    asio::signal_set reload_signal_;
    std::thread reader_;  // of a config that is read anew
    bool reloading_ = false;
    asio::steady_timer stop_timer_;
    asio::steady_timer status_timer_;
    wire::TrafficTable logged_traffic_;
    std::chrono::steady_clock::time_point farewell_end_;
    ParticleDevice particle_device_;  // outlives the world
    World world_;
    Network network_;
    std::unique_ptr<recording::RecordingWriter> recorder_;
    std::unique_ptr<TickLoop> loop_;
};

}  // namespace

int serve(const ServeArguments& arguments) {
    config::Settings settings;
    if (!load_or_complain(arguments.config, arguments.sets, settings)) {
        return kUsage;
    }
    set_up_log(settings);
    settings.replication.meter = settings.replication.meter || !arguments.report.empty();
    for (const std::string& warning : config::stability_warnings_of(settings)) {
        spdlog::warn("{}", warning);
    }
    Server server(arguments, settings);
    return server.run();
}

}  // namespace zoned::app
