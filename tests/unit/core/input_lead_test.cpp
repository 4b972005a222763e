#include "shared/clock/input_lead.h"

#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

namespace zoned::clock {
namespace {

constexpr double kTickS = 1.0 / 30.0;

/// A client that sends one packet per tick, each with the newest four commands. The server consumes
/// a command per tick and reports its observations a while later.
struct Client {
    core::Rng rng{1};
    InputLead lead{kTickS};
    std::function<double()> way = [] {
        return 0.05;
    };
    double loss = 0.0;
    bool told = true;         ///< the server's report of missing commands arrives
    bool paths_known = true;  ///< stamps of arrivals come back
    std::uint64_t consumed = 0;
    std::uint64_t missing = 0;
    double early_s = 0.0;  ///< sum over commands: how long they waited at the server
    double most_uneven = 0.0;

    struct News {
        double at_s = 0.0;
        double path_s = 0.0;
        int late = 0;
    };

    /// Runs from `from_s` on; counts from then.
    void run(double from_s, double until_s) {
        consumed = missing = 0;
        early_s = 0.0;
        if (!lead.begun()) {
            lead.begin(0.1, from_s);
            next_ = static_cast<long>(std::floor((from_s + lead.lead_s()) / kTickS));
            first_ = next_ + 1;
            arrivals_.assign(100000, 1e18);
            server_next_ = next_ + 1;
        }
        lead.set_loss(loss);
        for (double now = from_s; now < until_s; now += 0.002) {
            const double before = lead.lead_s();
            const double after = lead.advance(now);
            most_uneven = std::max(most_uneven, std::abs(after - before) / 0.002);
            if (static_cast<long>(std::floor((now + after) / kTickS)) > next_) {
                ++next_;
                send(now);
            }
            deliver(now);
            while (!news_.empty() && news_.front().at_s <= now) {
                lead.add_path(news_.front().path_s, news_.front().late);
                news_.pop_front();
            }
            for (; static_cast<double>(server_next_) * kTickS <= now; ++server_next_) {
                consume();
            }
        }
    }

    [[nodiscard]] double missing_share() const {
        return static_cast<double>(missing) / static_cast<double>(consumed);
    }

    [[nodiscard]] double mean_early_s() const {
        return early_s / static_cast<double>(consumed - missing);
    }

  private:
    void send(double now) {
        const double took = way();
        packets_.resize(static_cast<std::size_t>(next_) + 1, 1e18);
        if (static_cast<double>(rng.unit()) < loss) {
            return;
        }
        packets_.back() = now + took;
        for (long tick = next_; tick > next_ - 4 && tick >= 0; --tick) {
            double& at = arrivals_[static_cast<std::size_t>(tick) % arrivals_.size()];
            at = std::min(at, now + took);
        }
        if (paths_known) {
            // How many directly before it had not come by then, and whether it was the newest: the
            // server knows both when it comes (see deliver()).
            under_way_.emplace_back(next_, took);
        }
    }

    /// The server's reports of packets that arrived by now.
    void deliver(double now) {
        std::erase_if(under_way_, [&](const std::pair<long, double>& p) {
            const double at = packets_[static_cast<std::size_t>(p.first)];
            if (at > now) {
                return false;
            }
            if (p.first > newest_) {
                newest_ = p.first;
                int late = 0;
                while (late < 3 && p.first - late > first_ &&
                       packets_[static_cast<std::size_t>(p.first - late - 1)] > at) {
                    ++late;
                }
                news_.push_back({at + 0.05, p.second, late});
            }
            return true;
        });
    }

    void consume() {
        const double due = static_cast<double>(server_next_) * kTickS;
        const double at = arrivals_[static_cast<std::size_t>(server_next_) % arrivals_.size()];
        const bool late = at > due;
        ++consumed;
        missing += late ? 1 : 0;
        early_s += late ? 0.0 : due - at;
        if (told) {
            lead.on_feedback(late, 0.1);
        }
    }

    long next_ = 0;
    long server_next_ = 0;
    long newest_ = -1;
    long first_ = 0;
    std::vector<std::pair<long, double>> under_way_;
    std::vector<double> arrivals_;
    std::deque<News> news_;
    std::vector<double> packets_;  // when each arrives, by tick
};

TEST(InputLead, MissesLessThanOneInAThousandUnderJitter) {
    for (const double jitter : {0.0, 0.033, 0.1}) {
        std::uint64_t missing = 0;
        std::uint64_t consumed = 0;
        double early_s = 0.0;
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
            Client client;
            client.rng = core::Rng(seed);
            client.way = [&] {
                return std::max(0.0, 0.06 + jitter * (2.0 * client.rng.unit() - 1.0));
            };
            client.run(10.0, 25.0);
            client.run(25.0, 325.0);
            missing += client.missing;
            consumed += client.consumed;
            early_s += client.early_s;
        }
        EXPECT_LT(static_cast<double>(missing) / static_cast<double>(consumed),
                  InputLead::kMissingTarget)
            << jitter;
        // No earlier than needed: a mean command is early by the sum of four terms. These are the
        // jitter, the wait for its tick to end (none to one tick), the added share of the scatter,
        // and the server's correction.
        EXPECT_LT(early_s / static_cast<double>(consumed), 1.15 * jitter + 0.003 + kTickS)
            << jitter;
    }
}

TEST(InputLead, HoldsItsTargetForDelaysWithExponentialTails) {
    std::uint64_t missing = 0;
    std::uint64_t consumed = 0;
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        Client client;
        client.rng = core::Rng(seed);
        client.way = [&] {
            return 0.03 - 0.01 * std::log(1.0 - 0.999999 * client.rng.unit());
        };
        client.run(10.0, 40.0);
        client.run(40.0, 640.0);
        missing += client.missing;
        consumed += client.consumed;
    }
    EXPECT_LT(static_cast<double>(missing) / static_cast<double>(consumed),
              InputLead::kMissingTarget);
}

TEST(InputLead, RunsFasterOrSlowerAndNeverJumps) {
    Client client;
    double delay = 0.02;
    client.way = [&] {
        return delay;
    };
    client.run(10.0, 20.0);
    const double low = client.lead.lead_s();
    delay = 0.12;
    client.run(20.0, 30.0);
    const double high = client.lead.lead_s();
    EXPECT_NEAR(high - low, 0.1, 0.15 * 0.1 + kTickS);
    delay = 0.02;
    client.run(30.0, 60.0);
    // Samples older than kSamples packets are forgotten.
    EXPECT_NEAR(client.lead.lead_s(), low, kTickS);
    EXPECT_LE(client.most_uneven, InputLead::kSlew + 1e-9);
}

TEST(InputLead, AStepInDelayIsMadeUpForAsFastAsTheSlewAllows) {
    Client client;
    double delay = 0.02;
    client.way = [&] {
        return delay;
    };
    client.run(10.0, 20.0);
    delay = 0.08;
    // 60 ms at kSlew take 1.2 s, the report of it a round trip; then nothing is late.
    client.run(20.0, 20.0 + 0.06 / InputLead::kSlew + 0.3);
    EXPECT_GT(client.missing, 0U);
    client.run(20.0 + 0.06 / InputLead::kSlew + 0.3, 60.0);
    EXPECT_EQ(client.missing, 0U);
}

TEST(InputLead, LossCostsATickForEveryPacketThatMayBeLostInARow) {
    for (const double loss : {0.01, 0.05, 0.1}) {
        Client client;
        client.loss = loss;
        client.run(10.0, 25.0);
        client.run(25.0, 625.0);
        EXPECT_LT(client.missing_share(), InputLead::kMissingUnderLoss) << loss;
        EXPECT_LT(client.mean_early_s(), 4.0 * kTickS + 0.003) << loss;
    }
}

TEST(InputLead, TheServersWordAloneSuffices) {
    // No arrival is known, and half the round trip is not the delay up.
    Client client;
    client.paths_known = false;
    client.way = [] {
        return 0.115;
    };
    client.run(10.0, 40.0);
    client.run(40.0, 340.0);
    EXPECT_LT(client.missing_share(), 3.0 * InputLead::kMissingTarget);
    // The counter-check: without the server's report all commands are late.
    Client deaf;
    deaf.paths_known = false;
    deaf.told = false;
    deaf.way = client.way;
    deaf.run(10.0, 40.0);
    EXPECT_GT(deaf.missing_share(), 0.9);
}

TEST(InputLead, AnOutageDoesNotRaiseIt) {
    Client client;
    client.run(10.0, 20.0);
    const double before = client.lead.wanted_s();
    client.lead.add_path(5.0, 0);
    client.lead.add_path(std::nan(""), 0);
    EXPECT_EQ(client.lead.wanted_s(), before);
}

}  // namespace
}  // namespace zoned::clock
