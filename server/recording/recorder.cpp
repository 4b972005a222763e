#include "server/recording/recorder.h"

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <iterator>
#include <utility>

namespace zoned::recording {

namespace {

using core::Result;

constexpr double kMostBehind_s = 10.0;

// For await_written_inputs(): a process has one recorder that matters.
std::atomic<std::uint64_t> inputs_begun{0};
std::atomic<std::uint64_t> inputs_written{0};
std::atomic<sem_t*> writers_bell{nullptr};

constexpr long kLongestRest_ns = 100'000'000;

std::uint64_t writer_cpu_ns() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<std::uint64_t>(t.tv_sec) * 1000000000ULL +
           static_cast<std::uint64_t>(t.tv_nsec);
}

}  // namespace

/// Vectors that go to and fro between the tick loop and the writer.
struct Recorder::Pool {
    std::mutex mutex;
    std::vector<std::unique_ptr<Inputs>> free;
};

Recorder::Recorder(RecorderSettings settings, std::function<void(const std::string&)> tell)
    : settings_(std::move(settings)),
      tell_(std::move(tell)),
      pool_(std::make_shared<Pool>()),
      // Inputs and hashes of a tick are an entry each.
      most_entries_(2 * static_cast<std::size_t>(kMostBehind_s * settings_.rate_hz) + 2) {
    ::sem_init(&bell_, 0, 0);
}

Recorder::~Recorder() {
    if (thread_.joinable()) {
        {
            const std::lock_guard lock(mutex_);
            closing_ = true;
        }
        ::sem_post(&bell_);
        thread_.join();
    }
    if (copier_.joinable()) {
        copier_.join();
    }
    sem_t* own = &bell_;
    writers_bell.compare_exchange_strong(own, nullptr);
    ::sem_destroy(&bell_);
}

Result<bool> Recorder::open() {
    if (!settings_.file.empty()) {
        before_file_ = settings_.begins.tick;
        whole_tick_ = before_file_;
        const Result<bool> opened = file_.open(
            settings_.file, settings_.header, before_file_ > 0 ? &settings_.begins : nullptr);
        if (!opened.ok()) {
            return opened;
        }
        settings_.begins = {};
    }
    if (settings_.ring_s > 0.0) {
        const auto ticks = static_cast<std::uint64_t>(settings_.ring_s * settings_.rate_hz);
        const Result<bool> opened = ring_.open(settings_.ring_folder, ticks, settings_.header);
        if (!opened.ok()) {
            ++figures_.failures;
            tell_("the last inputs are not kept (recording.ring_s): " + opened.error());
        }
    }
    if (!settings_.journal_folder.empty()) {
        const Result<bool> opened = journal_.open(settings_.journal_folder, settings_.header);
        if (!opened.ok()) {
            return opened;
        }
    }
    writers_bell.store(&bell_);
    thread_ = std::thread([this] { run(); });
    return true;
}

std::shared_ptr<Inputs> Recorder::lend() {
    std::unique_ptr<Inputs> inputs;
    {
        const std::lock_guard lock(pool_->mutex);
        if (!pool_->free.empty()) {
            inputs = std::move(pool_->free.back());
            pool_->free.pop_back();
        }
    }
    if (!inputs) {
        inputs = std::make_unique<Inputs>();
    }
    const auto give_back = [pool = pool_](Inputs* used) {
        used->clear();
        const std::lock_guard lock(pool->mutex);
        pool->free.emplace_back(used);
    };
    return {inputs.release(), give_back};
}

bool Recorder::push(Entry entry, bool wake) {
    {
        const std::lock_guard lock(mutex_);
        if (overflowed_ || entries_.size() >= most_entries_) {
            overflowed_ = true;
            // Nobody waits for what will never be written.
            inputs_written.fetch_add(entry.inputs ? 1 : 0, std::memory_order_relaxed);
            return false;
        }
        entries_.push_back(std::move(entry));
        wake = wake || orders_wait_;
    }
    if (wake) {
        ::sem_post(&bell_);
    }
    return true;
}

void Recorder::begin_tick(Tick tick, std::shared_ptr<const Inputs> inputs) {
    inputs_begun.fetch_add(1, std::memory_order_relaxed);
    push({tick, std::move(inputs), {}, Upkeep::kNone, nullptr}, journal_.is_open());
}

void Recorder::end_tick(Tick tick, std::vector<std::uint64_t> hashes) {
    // They go to disk with the next tick: a replay needs the inputs, not these.
    push({tick, nullptr, std::move(hashes), Upkeep::kNone, nullptr}, false);
}

void Recorder::cut_journal(Tick last) {
    push({last, nullptr, {}, Upkeep::kCutJournal, nullptr}, false);
}

void Recorder::forget_journal(Tick through) {
    push({through, nullptr, {}, Upkeep::kForgetJournal, nullptr}, false);
}

void Recorder::cut_ring(Tick last) {
    push({last, nullptr, {}, Upkeep::kCutRing, nullptr}, false);
}

void Recorder::keep_ring_from(Tick state) {
    push({state, nullptr, {}, Upkeep::kKeepRing, nullptr}, false);
}

void Recorder::run() {
    std::vector<Entry> entries;
    std::vector<Order> orders;
    bool closing = false;
    bool overflowed = false;
    while (!closing) {
        rest();
        {
            const std::lock_guard lock(mutex_);
            entries.swap(entries_);
            std::move(orders_.begin(), orders_.end(), std::back_inserter(orders));
            orders_.clear();
            closing = closing_;
            overflowed = std::exchange(overflowed_, false);
            if (entries.empty() && orders.empty() && !closing && !overflowed) {
                continue;
            }
            figures_.behind_ticks_max =
                std::max<std::uint64_t>(figures_.behind_ticks_max, entries.size() / 2);
        }
        write_all(entries, orders);
        const auto begun = static_cast<std::uint64_t>(std::count_if(
            entries.begin(), entries.end(), [](const Entry& e) { return e.inputs != nullptr; }));
        file_.flush();
        ring_.flush();
        inputs_written.fetch_add(begun, std::memory_order_relaxed);
        if (overflowed) {
            fall_behind();
        }
        keep(entries);
        entries.clear();
        look_for_failures();
        const std::lock_guard lock(mutex_);
        orders_wait_ = !orders.empty();
        figures_.ticks += begun;
        figures_.bytes = file_.bytes();
        figures_.writer_cpu_ns = writer_cpu_ns();
    }
    for (const Order& order : orders) {
        order.answer(Result<std::string>::failure("the server stops"));
    }
}

void Recorder::rest() {
    timespec until{};
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += kLongestRest_ns;
    until.tv_sec += until.tv_nsec / 1'000'000'000;
    until.tv_nsec %= 1'000'000'000;
    while (::sem_clockwait(&bell_, CLOCK_MONOTONIC, &until) != 0 && errno == EINTR) {
    }
    while (::sem_trywait(&bell_) == 0) {  // one look serves all who rang
    }
}

void Recorder::sync_journal() {
    journal_.sync(settings_.journal_for_power);
    if (!journal_.error().empty() && !journal_.is_cut()) {
        journal_gap_ = JournalGap::kFailed;
    }
}

/// Tells the ticks that are in the journal now.
void Recorder::keep(const std::vector<Entry>& entries) {
    if (!journal_.is_open()) {
        return;
    }
    sync_journal();
    const auto newest = std::find_if(entries.rbegin(), entries.rend(), [](const Entry& entry) {
        return entry.inputs != nullptr;
    });
    if (newest != entries.rend() && settings_.kept) {
        settings_.kept(newest->tick);
    }
}

/// Orders are carried out between two ticks, as late as these entries allow.
void Recorder::write_all(const std::vector<Entry>& entries, std::vector<Order>& orders) {
    const bool ends_within = !entries.empty() && entries.back().inputs != nullptr;
    const std::size_t whole = entries.size() - (ends_within ? 1 : 0);
    for (std::size_t i = 0; i < whole; ++i) {
        write(entries[i]);
    }
    if (!orders.empty() && !within_tick_) {
        file_.flush();
        ring_.flush();
        carry_out(orders);
    }
    if (ends_within) {
        write(entries.back());
    }
}

void Recorder::write(const Entry& entry) {
    switch (entry.upkeep) {
        case Upkeep::kCutJournal:
            // Nobody asks a piece that has ended whether it failed.
            sync_journal();
            journal_.cut();
            if (journal_gap_ == JournalGap::kFailed) {
                journal_gap_ = JournalGap::kCut;
            }
            return;
        case Upkeep::kForgetJournal:
            if (journal_gap_ == JournalGap::kCut) {
                journal_gap_ = JournalGap::kNone;
            }
            journal_.forget(entry.tick);
            return;
        case Upkeep::kCutRing:
            ring_.cut();
            return;
        case Upkeep::kKeepRing:
            ring_.keep_from(entry.tick);
            return;
        case Upkeep::kNone:
            break;
    }
    if (entry.begins) {
        entry.begins->answer(begin_file(*entry.begins));
        return;
    }
    const std::string_view frame = entry.inputs ? encoder_.inputs(entry.tick, *entry.inputs)
                                                : encoder_.hashes(entry.tick, entry.hashes);
    file_.append(frame, entry.inputs != nullptr);
    ring_.append(frame, entry.tick, entry.inputs != nullptr);
    journal_.append(frame, entry.tick, entry.inputs != nullptr);
    within_tick_ = entry.inputs != nullptr;
    whole_tick_ = within_tick_ ? whole_tick_ : entry.tick;
}

/// Ticks were left out: no replay comes past them.
void Recorder::fall_behind() {
    file_.give_up("the disk is more than " + std::to_string(static_cast<int>(kMostBehind_s)) +
                  " s behind");
    ring_.restart();
    journal_.give_up("the disk is too slow");
    journal_gap_ = JournalGap::kFailed;
}

void Recorder::look_for_failures() {
    std::uint64_t failures = 0;
    if (!file_.error().empty() && !file_failure_logged_) {
        file_failure_logged_ = true;
        ++failures;
        tell_(file_.error() + "; nothing more is recorded, what is on disk ends with a whole tick");
    }
    if (ring_.error().empty()) {
        ring_failure_logged_ = false;
    } else if (!ring_failure_logged_) {
        ring_failure_logged_ = true;
        ++failures;
        tell_("the last inputs are not kept for now: " + ring_.error());
    }
    if (journal_.error().empty()) {
        journal_failure_logged_ = false;
    } else if (!journal_failure_logged_) {
        journal_failure_logged_ = true;
        ++failures;
        tell_("a crash from here until the next snapshot would lose what happens meanwhile: " +
              journal_.error());
    }
    const std::lock_guard lock(mutex_);
    figures_.failures += failures;
}

Result<bool> Recorder::close(bool keeps_ring) {
    if (thread_.joinable()) {
        {
            const std::lock_guard lock(mutex_);
            closing_ = true;
        }
        ::sem_post(&bell_);
        thread_.join();
    }
    if (copier_.joinable()) {
        copier_.join();
    }
    ring_.close(keeps_ring);
    if (!file_.is_open()) {
        return true;
    }
    Result<bool> closed = file_.close();
    if (!closed.ok() && !file_failure_logged_) {
        ++figures_.failures;
    }
    figures_.bytes = file_.bytes();
    return closed;
}

RecorderFigures Recorder::figures() const {
    const std::lock_guard lock(mutex_);
    return figures_;
}

void await_written_inputs(int most_ms) noexcept {
    if (sem_t* bell = writers_bell.load(); bell != nullptr) {
        ::sem_post(bell);
    }
    const timespec pause{0, 1000000};
    for (int ms = 0; ms < most_ms; ++ms) {
        if (inputs_written.load(std::memory_order_relaxed) >=
            inputs_begun.load(std::memory_order_relaxed)) {
            return;
        }
        nanosleep(&pause, nullptr);
    }
}

}  // namespace zoned::recording
