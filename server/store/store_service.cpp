#include "server/store/store_service.h"

#include "shared/core/signal_stack.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

namespace zoned::store {

namespace {

using Clock = std::chrono::steady_clock;

/// So many jobs go into one transaction at most: after a pause of the disk it stays small.
constexpr std::size_t kMostJobs = 256;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::int64_t unix_ms() {
    using namespace std::chrono;
    return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

/// A thread of this policy that wakes does not take the processor from the one that woke it: the
/// tick loop goes on, and the disk is in no hurry.
void yield_to_the_tick_loop() {
    const sched_param none{};
    static_cast<void>(::pthread_setschedparam(::pthread_self(), SCHED_BATCH, &none));
}

bool changes_something(const mailbox::StoreRequest& request) {
    return request.act == mailbox::StoreAct::kPut || request.act == mailbox::StoreAct::kRemove ||
           request.act == mailbox::StoreAct::kStand;
}

/// Makes changes of the requests; their keys stay for the answers.
void add_changes(std::vector<mailbox::StoreRequest>& requests,
                 const std::string& world,
                 std::vector<StoreChange>& out) {
    for (mailbox::StoreRequest& r : requests) {
        if (r.act == mailbox::StoreAct::kPut) {
            out.emplace_back(PutRecord{r.key, std::move(r.value)});
        } else if (r.act == mailbox::StoreAct::kRemove) {
            out.emplace_back(RemoveRecord{r.key});
        } else if (r.act == mailbox::StoreAct::kStand) {
            out.emplace_back(PutStand{r.key.account,
                                      r.key.character,
                                      {{r.position[0], r.position[1], r.position[2]}, world}});
        }
    }
}

}  // namespace

mailbox::StoreAnswer answer_to(const mailbox::StoreRequest& request, mailbox::StoreStatus status) {
    return {request.number, request.act, status, request.zone, request.target, request.key, {}};
}

StoreService::StoreService(std::unique_ptr<Store> store,
                           StoreServiceSettings settings,
                           StoreServiceOutput output,
                           std::function<StoreResult<bool>()> checkpoint)
    : store_(std::move(store)),
      settings_(std::move(settings)),
      output_(std::move(output)),
      checkpoint_(std::move(checkpoint)) {
    writer_ = std::thread([this] { run(); });
    if (checkpoint_) {
        checkpoints_ = std::thread([this] { run_checkpoints(); });
    }
}

StoreService::~StoreService() {
    stop();
}

void StoreService::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_one();
    checkpoint_wake_.notify_one();
    if (writer_.joinable()) {
        writer_.join();
    }
    if (checkpoints_.joinable()) {
        checkpoints_.join();
    }
}

std::uint64_t StoreService::push(Job& job) {
    for (const StoreChange& change : job.changes) {
        job.bytes += size_of(change);
    }
    for (const mailbox::StoreRequest& request : job.requests) {
        job.bytes += sizeof(mailbox::StoreRequest) + request.value.size();
    }
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        if (stopping_ || figures_.waiting_bytes + job.bytes > settings_.max_waiting_bytes) {
            figures_.refused += job.requests.size() + (job.requests.empty() ? 1 : 0);
            return 0;
        }
        figures_.waiting_bytes += job.bytes;
        number = job.number = ++next_;
        waiting_.push_back(std::move(job));
    }
    wake_.notify_one();
    return number;
}

std::uint64_t StoreService::submit(Tick tick, std::vector<mailbox::StoreRequest>&& requests) {
    // Of the rest the writer's thread makes changes: the tick loop has better things to do.
    Job job;
    for (mailbox::StoreRequest& r : requests) {
        if (r.act == mailbox::StoreAct::kEvent) {
            job.changes.emplace_back(AddEvent{unix_ms(),
                                              tick,
                                              r.zone.value,
                                              r.kind,
                                              std::move(r.key.account),
                                              std::move(r.key.key),
                                              std::move(r.value)});
        }
    }
    job.requests = std::move(requests);
    const std::uint64_t number = push(job);
    if (number == 0) {
        refuse(job);
    }
    return number;
}

void StoreService::submit(std::vector<StoreChange> changes, std::function<void(bool)> done) {
    Job job;
    job.changes = std::move(changes);
    job.done = std::move(done);
    if (push(job) == 0 && job.done) {
        job.done(false);
    }
}

void StoreService::log_in(NoteLogin login,
                          std::optional<UseTicket> ticket,
                          std::function<void(LoginResult)> done) {
    Job job;
    job.changes.emplace_back(login);
    if (ticket) {
        job.changes.emplace_back(*ticket);
    }
    job.login = std::move(login);
    job.logged_in = std::move(done);
    if (push(job) == 0) {
        job.logged_in({});
    }
}

void StoreService::read_records(std::string account,
                                std::function<void(std::optional<std::vector<PutRecord>>)> done) {
    Job job;
    job.records_of = std::move(account);
    job.records_read = std::move(done);
    if (push(job) == 0) {
        job.records_read(std::nullopt);
    }
}

StoreFigures StoreService::figures() const {
    const std::lock_guard lock(mutex_);
    return figures_;
}

void StoreService::run() {
    core::add_signal_stack();
    yield_to_the_tick_loop();
    std::vector<Job> jobs;
    double retry_s = settings_.retry_s;
    std::optional<Clock::time_point> stop_began;
    std::size_t known = 0;  // jobs whose changes are made
    while (true) {
        {
            std::unique_lock lock(mutex_);
            if (jobs.empty()) {
                wake_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
            }
            if (jobs.empty() && waiting_.empty()) {
                return;
            }
            known = jobs.size();
            while (!waiting_.empty() && jobs.size() < kMostJobs) {
                jobs.push_back(std::move(waiting_.front()));
                waiting_.pop_front();
            }
            if (stopping_ && !stop_began) {
                stop_began = Clock::now();
            }
        }
        for (; known < jobs.size(); ++known) {
            add_changes(jobs[known].requests, settings_.world, jobs[known].changes);
        }
        if (work(jobs)) {
            jobs.clear();
            retry_s = settings_.retry_s;
            continue;
        }
        std::unique_lock lock(mutex_);
        if (stop_began && seconds_since(*stop_began) > settings_.stop_patience_s) {
            for (const Job& job : jobs) {
                figures_.lost += job.changes.size();
            }
            for (const Job& job : waiting_) {
                figures_.lost += job.changes.size() +
                                 static_cast<std::uint64_t>(std::count_if(
                                     job.requests.begin(), job.requests.end(), &changes_something));
            }
            return;
        }
        const bool was_stopping = stopping_;
        wake_.wait_for(lock, std::chrono::duration<double>(retry_s), [this, was_stopping] {
            return stopping_ != was_stopping;
        });
        retry_s = std::min(2.0 * retry_s, settings_.most_retry_s);
    }
}

void StoreService::run_checkpoints() {
    core::add_signal_stack();
    yield_to_the_tick_loop();
    std::unique_lock lock(mutex_);
    const std::chrono::duration<double> pause(settings_.checkpoint_s);
    while (!checkpoint_wake_.wait_for(lock, pause, [this] { return stopping_; })) {
        lock.unlock();
        const bool good = checkpoint_().ok();
        lock.lock();
        figures_.checkpoint_failures += good ? 0 : 1;
    }
}

bool StoreService::work(std::vector<Job>& jobs) {
    batch_.clear();
    for (const Job& job : jobs) {
        batch_.insert(batch_.end(), job.changes.begin(), job.changes.end());
    }
    if (!batch_.empty()) {
        const Clock::time_point begin = Clock::now();
        const auto committed = store_->commit(batch_);
        if (!committed.ok()) {
            failed(committed.error());
            return false;
        }
        const std::lock_guard lock(mutex_);
        ++figures_.commits;
        figures_.changes += batch_.size();
        figures_.commit_ms.add(1e3 * seconds_since(begin));
    }
    worked();
    // From here on nothing is undone: a read that fails is an answer like any other.
    for (const Job& job : jobs) {
        answer(job);
        const std::lock_guard lock(mutex_);
        figures_.waiting_bytes -= job.bytes;
    }
    if (output_.durable) {
        output_.durable(jobs.back().number);
    }
    return true;
}

void StoreService::answer(const Job& job) {
    for (const mailbox::StoreRequest& request : job.requests) {
        if (request.number == 0) {
            continue;
        }
        mailbox::StoreAnswer out = answer_to(request, mailbox::StoreStatus::kDone);
        if (request.act == mailbox::StoreAct::kGet) {
            auto value = store_->get(request.key);
            const std::lock_guard lock(mutex_);
            ++figures_.reads;
            if (!value.ok()) {
                ++figures_.failures;
                out.status = mailbox::StoreStatus::kRefused;
            } else if (!*value) {
                out.status = mailbox::StoreStatus::kAbsent;
            } else {
                out.value = std::move(**value);
            }
        }
        output_.answer(std::move(out));
    }
    if (job.done) {
        job.done(true);
    }
    if (job.records_read) {
        auto records = store_->records(job.records_of);
        if (records.ok()) {
            job.records_read(std::move(*records));
        } else {
            job.records_read(std::nullopt);
        }
    }
    if (job.logged_in) {
        LoginResult result;
        auto place = store_->stand(job.login.account, job.login.character);
        result.stored = true;
        if (place.ok() && *place && (*place)->world == settings_.world) {
            result.place = std::move(*place);
        }
        job.logged_in(std::move(result));
    }
}

void StoreService::refuse(const Job& job) {
    for (const mailbox::StoreRequest& request : job.requests) {
        if (request.number != 0) {
            output_.answer(answer_to(request, mailbox::StoreStatus::kRefused));
        }
    }
}

void StoreService::failed(const StoreError& why) {
    bool fresh = false;
    {
        const std::lock_guard lock(mutex_);
        ++figures_.failures;
        fresh = figures_.failing != why.text;
        figures_.failing = why.text;
    }
    if (fresh && output_.trouble) {
        output_.trouble(why.text);
    }
}

void StoreService::worked() {
    {
        const std::lock_guard lock(mutex_);
        if (figures_.failing.empty()) {
            return;
        }
        figures_.failing.clear();
    }
    if (output_.trouble) {
        output_.trouble("");
    }
}

}  // namespace zoned::store
