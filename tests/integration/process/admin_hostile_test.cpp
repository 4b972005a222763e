// A live server whose admin port is attacked while players play: everything is refused with a
// reason that the metrics count, and no tick is late for it.
#include "tests/integration/process/admin_fixture.h"

#include <sys/resource.h>

#include <cstdlib>
#include <functional>

namespace zoned::testing_process {
namespace {

using testing_admin::RawSocket;
using testing_admin::send_raw;

const std::string kHead = " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n";

class Attacked : public Admin {
  protected:
    void SetUp() override {
        serve();
        join(2);
    }

    [[nodiscard]] std::string metric(const std::string& sample) const {
        const std::string text = testing_admin::get(admin_port, "/metrics");
        const std::size_t at = text.find("\n" + sample + " ");
        const std::size_t begin = at + sample.size() + 2;
        return at == std::string::npos ? "" : text.substr(begin, text.find('\n', begin) - begin);
    }

    [[nodiscard]] double value(const std::string& sample) const {
        const std::string text = metric(sample);
        return text.empty() ? 0.0 : std::stod(text);
    }

    [[nodiscard]] double refused(const std::string& reason) const {
        return value("zoned_admin_refused_total{reason=\"" + reason + "\"}");
    }

    /// Runs the attack and looks at the ticks meanwhile: none is left out, and none overruns by its
    /// own CPU time. (By the wall a busy machine may be late at any time.)
    void attack(const std::function<void()>& work) const {
        const std::string own =
            "zoned_tick_overruns_total{cause=\"step took longer than a period "
            "of CPU time\"}";
        const double ticks = value("zoned_ticks_total");
        const double overruns = value(own);
        const double cpu_max = value("zoned_tick_cpu_seconds{quantile=\"1\"}");
        work();
        // The world went on, with figures that are younger than the attack.
        std::this_thread::sleep_for(std::chrono::milliseconds(600));
        EXPECT_GT(value("zoned_ticks_total"), ticks);
        EXPECT_EQ(value(own), overruns);
        EXPECT_LT(value("zoned_tick_cpu_seconds{quantile=\"1\"}"), std::max(0.033, 2.0 * cpu_max));
        EXPECT_EQ(value("zoned_sessions"), 2.0);
    }
};

TEST_F(Attacked, RefusesWrongTokensAndCountsThem) {
    attack([&] {
        int unauthorized = 0;
        int flood = 0;
        for (int i = 0; i < 100; ++i) {
            const int status = status_of(
                send_raw(admin_port,
                         "GET /api/v1/status" + kHead + "Authorization: Bearer " +
                             std::string(64, static_cast<char>('a' + i % 6)) + "\r\n\r\n"));
            unauthorized += status == 401 ? 1 : 0;
            flood += status == 429 ? 1 : 0;
        }
        EXPECT_EQ(unauthorized + flood, 100);
        EXPECT_GT(unauthorized, 0);
        EXPECT_GT(flood, 0);
        EXPECT_EQ(status_of(testing_admin::get(admin_port, "/api/v1/status")) / 100, 4);
        // The holder of the token is let in all the same.
        EXPECT_EQ(status_of(ask("/api/v1/status")), 200);
        EXPECT_EQ(refused("token_wrong"), unauthorized);
        EXPECT_GE(refused("token_flood"), flood);
    });
}

TEST_F(Attacked, AnswersWhileTenThousandSocketsAreOpen) {
    rlimit limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
    rlimit more = limit;
    more.rlim_cur = std::min<rlim_t>(limit.rlim_max, 11000);
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &more), 0);
    attack([&] {
        std::vector<RawSocket> open;
        const auto most = static_cast<std::size_t>(std::min<rlim_t>(more.rlim_cur - 200, 10000));
        for (std::size_t i = 0; i < most; ++i) {
            open.emplace_back(admin_port);
            if (i % 3 == 0 && open.back().open()) {
                open.back().send("GET /heal");  // and never the rest
            }
        }
        EXPECT_EQ(status_of(testing_admin::get(admin_port, "/healthz")), 200);
        EXPECT_EQ(status_of(ask("/api/v1/status")), 200);
        EXPECT_GT(refused("evicted") + refused("connections"), 0.0);
    });
    EXPECT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
}

TEST_F(Attacked, DropsReadersThatDoNotRead) {
    attack([&] {
        constexpr int kReaders = 5;
        std::vector<RawSocket> slow;
        for (int i = 0; i < kReaders; ++i) {
            slow.emplace_back(admin_port, 4096);
            // Several megabytes of answers, none of which is read; few enough to be no flood.
            for (int k = 0; k < 100; ++k) {
                slow.back().send("GET /chart.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
            }
        }
        EXPECT_EQ(status_of(ask("/api/v1/status")), 200);
        // Their time to take an answer is ten seconds.
        for (int i = 0; i < 600 && refused("slow_reader") < kReaders; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        EXPECT_EQ(refused("slow_reader"), kReaders);
    });
}

TEST_F(Attacked, RefusesHugeBodiesAndHeaders) {
    attack([&] {
        const std::string post =
            "POST /api/v1/say" + kHead + bearer() + "Content-Type: application/json\r\n";
        EXPECT_EQ(status_of(send_raw(admin_port, post + "Content-Length: 1000000000000\r\n\r\n{")),
                  413);
        EXPECT_EQ(
            status_of(send_raw(admin_port,
                               post + "Content-Length: 200000\r\n\r\n" + std::string(200000, ' '))),
            413);
        std::string chunks = post + "Transfer-Encoding: chunked\r\n\r\n";
        for (int i = 0; i < 100; ++i) {
            chunks += "1000\r\n" + std::string(4096, ' ') + "\r\n";
        }
        EXPECT_EQ(status_of(send_raw(admin_port, chunks)), 413);
        EXPECT_EQ(
            status_of(send_raw(
                admin_port, "GET /healthz" + kHead + "X: " + std::string(9000, 'x') + "\r\n\r\n")),
            431);
        // Deep nesting must not eat the stack.
        const std::string deep(60000, '[');
        EXPECT_EQ(status_of(order("/api/v1/say", deep)), 400);
        EXPECT_EQ(refused("body_long"), 3.0);
        EXPECT_EQ(refused("header_long"), 1.0);
    });
}

TEST_F(Attacked, TakesNoPathTricks) {
    attack([&] {
        int tried = 0;
        for (const char* path : {"/../etc/passwd",
                                 "/..%2f..%2fetc/passwd",
                                 "/%2e%2e/etc/passwd",
                                 "//etc/passwd",
                                 "/./healthz",
                                 "/healthz%00.html",
                                 "/api/v1/entities/1/../../status",
                                 "/api/v1/entities/-1",
                                 "/api/v1/entities/4294967297",
                                 "/viewer.js/..",
                                 "\\windows",
                                 "http://127.0.0.1/healthz",
                                 "*"}) {
            const int status = status_of(
                send_raw(admin_port, std::string("GET ") + path + kHead + bearer() + "\r\n"));
            EXPECT_TRUE(status == 400 || status == 404) << path << " " << status;
            ++tried;
        }
        EXPECT_EQ(
            status_of(send_raw(admin_port, "GET /" + std::string(2000, 'a') + kHead + "\r\n")),
            414);
        EXPECT_EQ(refused("path") + refused("not_found") + refused("malformed"), tried);
        EXPECT_EQ(refused("target_long"), 1.0);
        EXPECT_EQ(
            status_of(send_raw(admin_port, "GET /api/v1/status?token=" + token() + kHead + "\r\n")),
            400);
        EXPECT_EQ(server->errors().find(token()), std::string::npos) << "the log holds the token";
    });
}

TEST_F(Attacked, RefusesRequestsOfOtherSites) {
    attack([&] {
        const std::string body = "{\"text\": \"hi\"}";
        double origins = 0.0;
        for (const char* header : {"Origin: http://evil.example\r\n",
                                   "Origin: null\r\n",
                                   "Origin: http://127.0.0.1:1\r\n",
                                   "Origin: https://127.0.0.1\r\n",
                                   "Sec-Fetch-Site: cross-site\r\n",
                                   "Sec-Fetch-Site: same-site\r\n"}) {
            EXPECT_EQ(status_of(order("/api/v1/say", body, header)), 403) << header;
            EXPECT_EQ(
                status_of(send_raw(admin_port,
                                   "GET /api/v1/spectate HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: "
                                   "websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: "
                                   "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                                   "Sec-WebSocket-Protocol: zoned, " +
                                       token() + "\r\n" + header + "\r\n")),
                403)
                << header;
            origins += 2.0;
        }
        EXPECT_EQ(refused("origin"), origins);
        // A name that another site made to point here (DNS rebinding).
        EXPECT_EQ(status_of(send_raw(admin_port,
                                     "GET /api/v1/status HTTP/1.1\r\nHost: evil.example\r\n"
                                     "Connection: close\r\n" +
                                         bearer() + "\r\n")),
                  421);
        EXPECT_EQ(refused("host"), 1.0);
        // A form needs no leave of the server to be sent, and cannot be of this type.
        EXPECT_EQ(
            status_of(send_raw(admin_port,
                               "POST /api/v1/drain" + kHead + bearer() +
                                   "Content-Type: text/plain\r\nContent-Length: 2\r\n\r\n{}")),
            415);
        EXPECT_EQ(refused("content_type"), 1.0);
        EXPECT_EQ(status_of(order("/api/v1/say", body)), 200);
    });
}

}  // namespace
}  // namespace zoned::testing_process
