#include "tests/browser/browser.h"

#include "tests/unit/json_reader.h"
#include "shared/core/json.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <gtest/gtest.h>
#include <openssl/evp.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

namespace zoned::testing_browser {

namespace {

namespace websocket = boost::beast::websocket;
using google::protobuf::Struct;
using tcp = boost::asio::ip::tcp;

constexpr const char* kProgram = "/usr/bin/chromium";

Struct object_of(const Struct& object, const std::string& name) {
    return json_text::field(object, name).struct_value();
}

bool has_field(const Struct& object, const std::string& name) {
    return object.fields().count(name) != 0;
}

/// The parameters of Runtime.evaluate.
std::string evaluation_of(const std::string& expression) {
    return R"({"awaitPromise": true, "returnByValue": true, "expression": )" +
           core::json_quote("Promise.resolve(" + expression + ").then(String)") + "}";
}

/// Of its result.
std::string value_of(const Struct& answer) {
    const Struct result = object_of(answer, "result");
    return has_field(result, "value") ? json_text::field(result, "value").string_value() : "";
}

std::string decode_base64(const std::string& text) {
    std::string out(text.size(), '\0');
    const int bytes = EVP_DecodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                                      reinterpret_cast<const unsigned char*>(text.data()),
                                      static_cast<int>(text.size()));
    out.resize(static_cast<std::size_t>(std::max(0, bytes)));
    return out;
}

}  // namespace

struct Browser::Socket {
    boost::asio::io_context io;
    websocket::stream<tcp::socket> stream{io};
};

bool has_browser() {
    return ::access(kProgram, X_OK) == 0;
}

Browser::Browser() : socket_(std::make_unique<Socket>()) {
    const std::string folder = testing_process::scratch_folder() + "/browser";
    // It makes folders of its own beside the one that it is told, and leaves them behind.
    process_ = std::make_unique<testing_process::Child>(
        "/usr/bin/env",
        std::vector<std::string>{"TMPDIR=" + testing_process::scratch_folder(),
                                 kProgram,
                                 "--headless=new",
                                 "--no-sandbox",
                                 "--no-first-run",
                                 "--disable-extensions",
                                 "--disable-background-networking",
                                 "--enable-unsafe-swiftshader",
                                 "--window-size=1000,700",
                                 "--remote-debugging-port=0",
                                 "--user-data-dir=" + folder,
                                 "about:blank"});
    const std::string mark = "DevTools listening on ws://127.0.0.1:";
    std::string said;
    for (int i = 0; i < 600 && said.find(mark) == std::string::npos; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        said = process_->errors();
    }
    const std::size_t at = said.find(mark);
    if (at == std::string::npos) {
        throw std::runtime_error("the browser does not start: " + said);
    }
    std::string address = said.substr(at + mark.size());
    address.resize(address.find_first_of("\r\n"));
    const std::size_t slash = address.find('/');
    socket_->stream.next_layer().connect(
        {boost::asio::ip::address_v4::loopback(),
         static_cast<std::uint16_t>(std::stoi(address.substr(0, slash)))});
    socket_->stream.read_message_max(64U << 20U);
    socket_->stream.handshake("127.0.0.1", address.substr(slash));
    const std::string target =
        json_text::field(command("Target.createTarget", R"({"url": "about:blank"})"), "targetId")
            .string_value();
    session_ = json_text::field(
                   command("Target.attachToTarget",
                           R"({"flatten": true, "targetId": )" + core::json_quote(target) + "}"),
                   "sessionId")
                   .string_value();
    for (const char* domain : {"Runtime.enable", "Log.enable", "Page.enable"}) {
        command(domain, "{}");
    }
}

Browser::~Browser() = default;

Struct Browser::answer_to(const std::string& method, const std::string& parameters) {
    const int id = ++last_id_;
    const std::string session =
        session_.empty() ? "" : R"(, "sessionId": )" + core::json_quote(session_);
    socket_->stream.write(boost::asio::buffer(R"({"id": )" + std::to_string(id) +
                                              R"(, "method": )" + core::json_quote(method) +
                                              session + R"(, "params": )" + parameters + "}"));
    for (;;) {
        boost::beast::flat_buffer buffer;
        socket_->stream.read(buffer);
        const std::string text = boost::beast::buffers_to_string(buffer.data());
        const Struct message = json_text::parse(text);
        if (has_field(message, "id")) {
            if (static_cast<int>(json_text::field(message, "id").number_value()) == id) {
                return message;
            }
            continue;
        }
        const std::string event = json_text::field(message, "method").string_value();
        const bool error_logged =
            (event == "Log.entryAdded" && text.find(R"("level":"error")") != std::string::npos) ||
            (event == "Runtime.consoleAPICalled" &&
             text.find(R"("type":"error")") != std::string::npos);
        if (event == "Runtime.exceptionThrown" || error_logged) {
            errors_.push_back(text);
        }
    }
}

Struct Browser::command(const std::string& method, const std::string& parameters) {
    const Struct message = answer_to(method, parameters);
    EXPECT_FALSE(has_field(message, "error")) << method << ": " << message.ShortDebugString();
    return has_field(message, "result") ? object_of(message, "result") : Struct();
}

void Browser::open(const std::string& url) {
    command("Page.navigate", R"({"url": )" + core::json_quote(url) + "}");
}

std::string Browser::evaluate(const std::string& expression) {
    return value_of(command("Runtime.evaluate", evaluation_of(expression)));
}

bool Browser::wait_until(const std::string& expression, double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
        const Struct message = answer_to("Runtime.evaluate", evaluation_of(expression));
        // A page that loads anew in the meantime takes the question with it: an error, no result.
        if (has_field(message, "result") && value_of(object_of(message, "result")) == "true") {
            return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
}

void Browser::click(double x, double y) {
    const std::string at = R"(, "button": "left", "clickCount": 1, "x": )" + std::to_string(x) +
                           R"(, "y": )" + std::to_string(y) + "}";
    command("Input.dispatchMouseEvent", R"({"type": "mousePressed")" + at);
    command("Input.dispatchMouseEvent", R"({"type": "mouseReleased")" + at);
}

void Browser::key(const std::string& code, const std::string& name, bool down) {
    command("Input.dispatchKeyEvent",
            R"({"type": ")" + std::string(down ? "keyDown" : "keyUp") + R"(", "code": )" +
                core::json_quote(code) + R"(, "key": )" + core::json_quote(name) + "}");
}

void Browser::press(const std::string& name, int virtual_key) {
    const std::string text = name == "Enter" ? R"(, "text": "\r")" : "";
    const std::string which = R"(, "key": )" + core::json_quote(name) + R"(, "code": )" +
                              core::json_quote(name) + R"(, "windowsVirtualKeyCode": )" +
                              std::to_string(virtual_key);
    command("Input.dispatchKeyEvent", R"({"type": "keyDown")" + which + text + "}");
    command("Input.dispatchKeyEvent", R"({"type": "keyUp")" + which + "}");
}

void Browser::ignore_policies() {
    command("Page.setBypassCSP", R"({"enabled": true})");
}

void Browser::set_dark(bool dark) {
    command("Emulation.setEmulatedMedia",
            std::string(R"({"features": [{"name": "prefers-color-scheme", "value": ")") +
                (dark ? "dark" : "light") + R"("}]})");
}

void Browser::set_size(int width, int height) {
    command("Emulation.setDeviceMetricsOverride",
            R"({"deviceScaleFactor": 1, "mobile": false, "width": )" + std::to_string(width) +
                R"(, "height": )" + std::to_string(height) + "}");
}

void Browser::screenshot(const std::string& file) {
    const Struct answer = command("Page.captureScreenshot", "{}");
    std::ofstream(file, std::ios::binary)
        << decode_base64(json_text::field(answer, "data").string_value());
}

Browser::Memory Browser::memory() {
    command("HeapProfiler.collectGarbage", "{}");
    const Struct heap = command("Runtime.getHeapUsage", "{}");
    const Struct counters = command("Memory.getDOMCounters", "{}");
    return {json_text::field(heap, "usedSize").number_value(),
            json_text::field(counters, "nodes").number_value()};
}

}  // namespace zoned::testing_browser
