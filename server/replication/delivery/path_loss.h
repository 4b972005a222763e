// PathLoss: the share of its packets that the path to one client is known to have lost.
#pragma once

namespace zoned::replication {

/// Counts what is known and nothing else. A packet arrived when an acknowledgement names it. It is
/// lost when acknowledgements that reach back to it leave it out and it is later than reordering
/// explains. A packet whose acknowledgement is late, or that no acknowledgement ever reached back
/// to, is neither. A packet that comes after it counted as lost takes that back (Eifel, RFC 3522).
///
/// A new path is taken for a poor one, so that the first seconds on a poor one are not the worst.
/// The guess is soon forgotten: copies ahead of losses would be the more, the more clients join.
class PathLoss {
  public:
    /// Of a new path.
    PathLoss() : packets_(kAtFirst) { note(kGuess); }

    /// `share`: as another zone has measured it, 0..1.
    explicit PathLoss(double share) : packets_(kMemory) { note(share); }

    void on_arrived() { count(0.0); }

    void on_lost() { count(1.0); }

    /// A packet that on_lost() counted has come.
    void on_found() { note(share_ > 1.0 / packets_ ? share_ - 1.0 / packets_ : 0.0); }

    /// Of the last packets, 0..1.
    [[nodiscard]] double share() const { return share_; }

    /// Copies of an update so that the chance to lose them all is below `target`, 1..8. One where
    /// the path has lost nothing of late.
    [[nodiscard]] int copies_wanted(float target) const {
        int copies = 1;
        for (double all_lost = share_;
             lossy_ && all_lost >= static_cast<double>(target) && copies < kMost;
             ++copies) {
            all_lost *= share_;
        }
        return copies;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(share_, packets_, lossy_);
    }

  private:
    static constexpr double kMemory = 64.0;  ///< packets; the first ones count for more ...
    static constexpr double kAtFirst = 4.0;  ///< ... beside a guess that counts as so many
    static constexpr double kGuess = 0.02;   ///< forgotten after 75 packets without a loss
    static constexpr double kLossy = 0.01;   ///< the first loss
    static constexpr double kClean = 0.001;  ///< about 180 packets after one alone
    static constexpr int kMost = 8;

    void count(double lost) {
        packets_ = packets_ < kMemory ? packets_ + 1.0 : kMemory;
        note(share_ + (lost - share_) / packets_);
    }

    void note(double share) {
        share_ = share;
        lossy_ = share > (lossy_ ? kClean : kLossy);
    }

    double share_ = 0.0;
    double packets_;  // that the share stands for
    bool lossy_ = false;
};

}  // namespace zoned::replication
