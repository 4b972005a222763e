// Suite `store`: how fast changes become durable, what a tick pays for it, how long a backup takes.
#include "server/app/runtime/tick_loop.h"
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/store/sqlite_store.h"
#include "server/store/store_service.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite.h"

#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <thread>

namespace zoned::bench {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kRate_hz = 30.0;
constexpr int kRows = 50;

const std::string kCommits = "commits_30hz";
const std::string kEvents = "events";
const std::string kTicksWithStore = "ticks";
const std::string kBackup = "backup";

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// A file of its own in the present folder: the folder for temporary files may lie in memory.
class StoreFile {
  public:
    StoreFile() : path_("store-bench-" + std::to_string(::getpid()) + ".db") { remove(); }

    ~StoreFile() { remove(); }

    StoreFile(const StoreFile&) = delete;
    StoreFile& operator=(const StoreFile&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }

    [[nodiscard]] std::unique_ptr<store::Store> open(store::Durability durability) const {
        auto opened = store::open_sqlite_store(path_, durability);
        if (!opened.ok()) {
            throw std::runtime_error(opened.error().text);
        }
        return std::move(*opened);
    }

  private:
    void remove() const {
        for (const char* ending : {"", "-wal", "-shm", ".copy"}) {
            std::error_code ignored;
            std::filesystem::remove(path_ + ending, ignored);
        }
    }

    std::string path_;
};

/// The writer of a server, and when it has come how far.
class Writer {
  public:
    Writer(const StoreFile& file, store::Durability durability)
        : service_(file.open(durability),
                   {},
                   {[](mailbox::StoreAnswer) {},
                    [this](std::uint64_t number) {
                        const std::lock_guard lock(mutex_);
                        durable_ = number;
                        changed_.notify_all();
                    },
                    {}},
                   [checkpoint = std::make_shared<store::SqliteCheckpoint>(file.path())] {
                       return checkpoint->run();
                   }) {}

    std::uint64_t submit(Tick tick, std::vector<mailbox::StoreRequest>&& requests) {
        return service_.submit(tick, std::move(requests));
    }

    void wait_for(std::uint64_t number) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return durable_ >= number; });
    }

    [[nodiscard]] store::StoreFigures figures() const { return service_.figures(); }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::uint64_t durable_ = 0;
    store::StoreService service_;  // ends first
};

/// A tick's worth: each player's record, 200 bytes as an inventory takes.
std::vector<mailbox::StoreRequest> rows_of(Tick tick, int count) {
    std::vector<mailbox::StoreRequest> out(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        mailbox::StoreRequest& row = out[static_cast<std::size_t>(i)];
        row.act = mailbox::StoreAct::kPut;
        row.number = static_cast<std::uint64_t>(i + 1);
        row.zone = ZoneId(1);
        row.key = {mailbox::StoreScope::kCharacter,
                   "account" + std::to_string((tick * 7 + i) % 1000),
                   "hero",
                   "bag"};
        row.value.assign(200, static_cast<std::uint8_t>(tick));
    }
    return out;
}

std::vector<mailbox::StoreRequest> events_of(int count) {
    std::vector<mailbox::StoreRequest> out = rows_of(0, count);
    for (mailbox::StoreRequest& event : out) {
        event.act = mailbox::StoreAct::kEvent;
        event.number = 0;
        event.key = {mailbox::StoreScope::kWorld, event.key.account, {}, {}};
        event.value.resize(40);
    }
    return out;
}

Row row_of(const std::string& scene, const std::string& method) {
    Row row;
    row.suite = "store";
    row.scene = scene;
    row.method = method;
    return row;
}

store::Durability durability_of(const std::string& method) {
    return method == "process" ? store::Durability::kProcess : store::Durability::kPower;
}

Row commits(const std::string& method, double seconds) {
    const StoreFile file;
    Writer writer(file, durability_of(method));
    std::vector<double> us;
    const Clock::time_point begin = Clock::now();
    for (Tick tick = 1; static_cast<double>(tick) < seconds * kRate_hz; ++tick) {
        std::this_thread::sleep_until(
            begin + std::chrono::duration_cast<Clock::duration>(
                        std::chrono::duration<double>(static_cast<double>(tick) / kRate_hz)));
        const Clock::time_point handed = Clock::now();
        writer.wait_for(writer.submit(tick, rows_of(tick, kRows)));
        us.push_back(1e6 * seconds_since(handed));
    }
    Row row = row_of(kCommits, method);
    row.parameter = "rows=" + std::to_string(kRows);
    row.time_us_p50 = quantile(us, 0.5);
    row.time_us_p99 = quantile(us, 0.99);
    row.metric("time_us_max", largest(us));
    return row;
}

Row events(const std::string& method, double seconds) {
    constexpr int kATick = 100;
    const StoreFile file;
    Writer writer(file, durability_of(method));
    std::vector<double> us;
    std::uint64_t done = 0;
    const Clock::time_point begin = Clock::now();
    while (seconds_since(begin) < seconds) {
        const Clock::time_point handed = Clock::now();
        writer.wait_for(writer.submit(1, events_of(kATick)));
        us.push_back(1e6 * seconds_since(handed));
        done += kATick;
    }
    Row row = row_of(kEvents, method);
    row.parameter = "a_tick=" + std::to_string(kATick);
    row.time_us_p50 = quantile(us, 0.5);
    row.time_us_p99 = quantile(us, 0.99);
    row.metric("durable_events_per_s", static_cast<double>(done) / seconds_since(begin));
    return row;
}

/// Phases with and without the store take turns in one run of `valley` with players.
void ticks(Session& session, double seconds) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(ZONED_SOURCE_DIR "/config/valley.txtpb", {}, settings, errors)) {
        session.note("store: config/valley.txtpb could not be read");
        return;
    }
    app::World world(settings, 1);
    std::vector<mailbox::InboxItem> joins;
    for (std::uint32_t i = 1; i <= 100; ++i) {
        mailbox::Join join;
        join.client = ClientId(i);
        join.name = "player" + std::to_string(i);
        joins.emplace_back(std::move(join));
    }
    std::vector<mailbox::OutboxItem> out;
    world.tick(joins, out);
    const StoreFile file;
    Writer writer(file, store::Durability::kPower);
    std::vector<double> off_us;
    std::vector<double> on_us;
    std::vector<double> off_cpu_us;
    std::vector<double> on_cpu_us;
    const auto phase = static_cast<Tick>(kRate_hz);
    const Clock::time_point begin = Clock::now();
    for (Tick tick = 1; static_cast<double>(tick) < seconds * kRate_hz; ++tick) {
        std::this_thread::sleep_until(
            begin + std::chrono::duration_cast<Clock::duration>(
                        std::chrono::duration<double>(static_cast<double>(tick) / kRate_hz)));
        const bool on = tick / phase % 2 == 1;
        auto rows = rows_of(tick, kRows);
        out.clear();
        const Clock::time_point start = Clock::now();
        const std::uint64_t start_ns = app::thread_cpu_ns();
        world.tick({}, out);
        if (on) {
            writer.submit(tick, std::move(rows));
        }
        (on ? on_us : off_us).push_back(1e6 * seconds_since(start));
        (on ? on_cpu_us : off_cpu_us)
            .push_back(1e-3 * static_cast<double>(app::thread_cpu_ns() - start_ns));
    }
    Row off = row_of(kTicksWithStore, "off");
    off.time_us_p50 = quantile(off_us, 0.5);
    off.time_us_p99 = quantile(off_us, 0.99);
    Row with = row_of(kTicksWithStore, "default");
    with.parameter = "rows=" + std::to_string(kRows);
    with.time_us_p50 = quantile(on_us, 0.5);
    with.time_us_p99 = quantile(on_us, 0.99);
    with.metric("tick_p99_over_off", with.time_us_p99 / off.time_us_p99);
    with.metric("tick_p50_over_off", with.time_us_p50 / off.time_us_p50);
    with.metric("tick_cpu_p99_over_off", quantile(on_cpu_us, 0.99) / quantile(off_cpu_us, 0.99));
    with.metric("tick_cpu_p50_over_off", quantile(on_cpu_us, 0.5) / quantile(off_cpu_us, 0.5));
    with.metric("refused", static_cast<double>(writer.figures().refused));
    session.add({with, off});
}

Row backup(int megabytes) {
    const StoreFile file;
    const auto store = file.open(store::Durability::kProcess);
    for (int i = 0; i < megabytes * 16; ++i) {
        const std::vector<store::StoreChange> change{
            store::PutRecord{{mailbox::StoreScope::kWorld, {}, {}, "key" + std::to_string(i)},
                             store::StoredBytes(65000, static_cast<std::uint8_t>(i))}};
        if (!store->commit(change).ok()) {
            throw std::runtime_error("the store of the benchmark could not be filled");
        }
    }
    const Clock::time_point begin = Clock::now();
    const auto done = store->backup(file.path() + ".copy");
    if (!done.ok()) {
        throw std::runtime_error(done.error().text);
    }
    Row row = row_of(kBackup, "default");
    row.time_us_p50 = row.time_us_p99 = 1e6 * seconds_since(begin);
    row.metric("size_mb",
               1e-6 * static_cast<double>(std::filesystem::file_size(file.path() + ".copy")));
    return row;
}

void run_store(Session& session) {
    const double seconds = session.quick ? 2.0 : 30.0;
    for (const char* method : {"default", "process"}) {
        if (session.wants_scene(kCommits) && session.wants_method(method, "")) {
            session.progress("store commits " + std::string(method));
            session.add({commits(method, seconds)});
        }
        if (session.wants_scene(kEvents) && session.wants_method(method, "")) {
            session.progress("store events " + std::string(method));
            session.add({events(method, 0.3 * seconds)});
        }
    }
    if (session.wants_scene(kTicksWithStore)) {
        session.progress("store ticks");
        ticks(session, 2.0 * seconds);
    }
    if (session.wants_scene(kBackup)) {
        session.progress("store backup");
        session.add({backup(session.quick ? 4 : 36)});
    }
    session.note("store: times are by the wall, and the files lie in the present folder");
}

const Registration kStore({"store",
                           "how fast changes become durable, and what a tick pays for it",
                           {kCommits, kEvents, kTicksWithStore, kBackup},
                           {"default", "process", "off"},
                           run_store});

}  // namespace

}  // namespace zoned::bench
