// The client for pages of a studio's own: the installed module, its types, and the example page on
// a site of its own.
#include "tests/browser/viewer_fixture.h"

#include <filesystem>

namespace zoned::testing_browser {
namespace {

namespace fs = std::filesystem;
using testing_process::Child;
using testing_process::kPatience;
using testing_process::read;
using testing_process::scratch_folder;

const std::vector<std::string> kStrict{"--strict",
                                       "--noUncheckedIndexedAccess",
                                       "false",
                                       "--pretty",
                                       "false",
                                       "--target",
                                       "es2022",
                                       "--module",
                                       "es2022",
                                       "--lib",
                                       "es2022,dom"};

class TypedClient : public testing_process::Process {
  protected:
    void SetUp() override {
        ASSERT_TRUE(fs::exists("/usr/bin/tsc"))
            << "node-typescript is not installed (config/packages.txt)";
        const std::string prefix = scratch_folder() + "/prefix";
        Child install(
            "/usr/bin/cmake",
            {"--install", ZONED_BINARY_DIR, "--prefix", prefix, "--component", "Unspecified"});
        ASSERT_EQ(install.wait(kPatience), 0) << install.output() << install.errors();
        folder = prefix + "/share/zoned/client/web";
    }

    /// Complaints of the compiler about a file in the installed folder; empty: there are none.
    [[nodiscard]] std::string compile(const std::string& file,
                                      const std::vector<std::string>& more = {"--noEmit"}) const {
        std::vector<std::string> arguments = kStrict;
        arguments.insert(arguments.end(), more.begin(), more.end());
        arguments.push_back(file.starts_with('/') ? file : folder + "/" + file);
        Child tsc("/usr/bin/tsc", arguments);
        const int code = tsc.wait(2.0 * kPatience);
        const std::string said = tsc.output() + tsc.errors();
        EXPECT_EQ(code == 0, said.empty()) << said;
        return said;
    }

    std::string folder;  // where the module was installed
};

TEST_F(TypedClient, DeclarationsAreThoseOfTheSource) {
    const std::string source = ZONED_SOURCE_DIR "/client-sim/web/zoned_client";
    EXPECT_EQ(compile(source + ".ts",
                      {"--declaration", "--emitDeclarationOnly", "--outDir", scratch_folder()}),
              "");
    EXPECT_EQ(read(scratch_folder() + "/zoned_client.d.ts"), read(source + ".d.ts"))
        << "zoned_client.ts is not as its declarations say: write them anew by tsc --strict "
           "--target es2022 --declaration --emitDeclarationOnly client-sim/web/zoned_client.ts";
}

TEST_F(TypedClient, FindsEachWrongUse) {
    const std::string begin =
        "import { WebClient, load } from './zoned_client.js';\n"
        "const code = await load(await fetch('zoned_client.wasm'));\n"
        "const client = new WebClient(code, { name: 'ann', view: 1 });\n";
    const std::vector<std::string> right{
        "client.input({ moveX: 1 });",
        "client.command(16, new Uint8Array(4));",
        "const x: number | undefined = client.own()?.position[0];",
        "const moving = client.entities().filter(({ atRest }) => !atRest);",
        "const health = client.field(1, 'health');",
        "if (typeof health === 'number') { health.toFixed(1); }"};
    const std::vector<std::string> wrong{
        "new WebClient(code, { team: 'red' });",           // nobody without a name
        "new WebClient(code, { name: 'ann', view: 2 });",  // there are two views
        "client.begin(7780);",                             // an address is wanted
        "client.input({ moveY: 1 });",                     // walks on the ground
        "client.command(16, 'text');",                     // bytes are wanted
        "client.own().position[0];",                       // not before it is born
        "client.entities()[0].position[3];",               // three axes
        "const n: number = client.field(1, 'health')!;",   // it may be a text
        "client.socket_();",                               // no such function
        "const s: 'online' = client.poll();"};             // states are numbers
    const auto file = [&](const std::string& name, const std::vector<std::string>& lines) {
        std::ofstream out(folder + "/" + name);
        out << begin;
        for (const std::string& line : lines) {
            out << line << "\n";
        }
    };
    file("right.ts", right);
    EXPECT_EQ(compile("right.ts"), "");
    file("wrong.ts", wrong);
    const std::string said = compile("wrong.ts");
    for (std::size_t i = 0; i < wrong.size(); ++i) {
        EXPECT_NE(said.find("wrong.ts(" + std::to_string(4 + i) + ","), std::string::npos)
            << wrong[i] << " passes:\n"
            << said;
    }
    EXPECT_EQ(said.find("wrong.ts(1,"), std::string::npos) << said;
}

TEST_F(TypedClient, PageOfAnotherSiteJoinsSeesAndWalks) {
    ASSERT_TRUE(has_browser()) << "chromium is not installed (config/packages.txt)";
    EXPECT_EQ(compile("look_around.ts", {"--outDir", folder}), "");
    Child site("/usr/bin/python3",
               {"-u", "-m", "http.server", "0", "--bind", "127.0.0.1", "--directory", folder});
    ASSERT_TRUE(site.wait_for_output("port ", kPatience)) << site.errors();
    const std::string origin =
        "http://127.0.0.1:" + std::to_string(testing_process::number_after(site.output(), "port "));
    const auto server = start_server({"--set",
                                      "network.websocket_port=0",
                                      "--set",
                                      "network.websocket_origin=\"" + origin + "\""});
    const int port = testing_process::number_after(server->output(), "websocket=");
    Browser browser;
    browser.open(origin +
                 "/look_around.html?name=ann&server=ws://127.0.0.1:" + std::to_string(port) + "/");
    const std::string status = "document.getElementById('status').textContent";
    ASSERT_TRUE(browser.wait_until(status + ".includes('10 crate, 2 wanderer')", kPatience))
        << browser.evaluate(status) << server->errors();
    const std::string own = "client.own().position";
    const double z = std::stod(browser.evaluate(own + "[2]"));
    browser.key("KeyW", "w", true);
    EXPECT_TRUE(browser.wait_until(own + "[2] > " + std::to_string(z + 2.0)));
    browser.key("KeyW", "w", false);
    // Upright types are turned about the vertical axis alone, by a unit quaternion.
    EXPECT_EQ(
        browser.evaluate("client.entities().filter((e) => client.types()[e.type].upright).every(({ "
                         "orientation: [x, y, z, w] }) => Math.abs(x) + Math.abs(z) < 1e-3 && "
                         "Math.abs(Math.hypot(y, w) - 1) < 1e-3)"),
        "true")
        << browser.evaluate("JSON.stringify(client.entities())");
    EXPECT_EQ(browser.evaluate("client.entities().filter(({ velocity: [x, , z], atRest }) => "
                               "!atRest && Math.hypot(x, z) > 0.1).length > 0"),
              "true")
        << "no wanderer walks";
    browser.evaluate("(() => { window.client.quit(); return ''; })()");
    EXPECT_TRUE(browser.wait_until("client.state === 4"));
    for (const std::string& error : browser.errors()) {
        ADD_FAILURE() << error;
    }
}

}  // namespace
}  // namespace zoned::testing_browser
