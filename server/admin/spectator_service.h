// SpectatorService: the viewers of an admin server; it asks for samples while somebody looks.
#pragma once

#include "server/admin/admin_request.h"
#include "server/admin/admin_stream.h"
#include "server/admin/spectator/spectator_layers.h"
#include "server/admin/spectator_connection.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>

#include <map>
#include <memory>
#include <string>

namespace zoned::admin {

/// So many viewers look at a time.
inline constexpr std::size_t kMostViewers = 16;

/// Used by the admin server's thread alone.
class SpectatorService {
  public:
    /// `count` is kept at the number of viewers. All references must outlive this.
    SpectatorService(boost::asio::io_context& io,
                     AdminRouter& router,
                     SpectatorSource source,
                     std::size_t& count);

    /// 101 where the request may become a viewer, else the refusal.
    [[nodiscard]] AdminResponse admit(const AdminRequest& request) const;

    void add(AdminStream stream,
             const SpectatorConnection::UpgradeRequest& request,
             std::uint64_t number);

    /// Closes all viewers, for good.
    void close();

  private:
    void sample();
    void show();

    boost::asio::io_context& io_;
    AdminRouter& router_;
    SpectatorSource source_;
    std::size_t& count_;
    boost::asio::steady_timer timer_;
    std::map<std::uint64_t, std::shared_ptr<SpectatorConnection>> viewers_;
    std::shared_ptr<SpectatorSample> sample_ = std::make_shared<SpectatorSample>();
    std::vector<SpectatorWish> wishes_;
    SpectatorHub hub_;
    SpectatorLayers layers_;
    std::uint64_t shown_ = 0;
    bool fresh_ = false;     ///< a viewer came since the last update
    bool sampling_ = false;  ///< the timer runs
    bool asked_ = false;     ///< and an answer has not come yet
};

}  // namespace zoned::admin
