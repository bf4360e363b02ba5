#include "firmware/base/yaml_document.h"

#include <yaml-cpp/eventhandler.h>

#include <sstream>

namespace adit::base {
namespace {

/// Takes a document and forgets it.
class Listener : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
  }
  void OnMapEnd() override {}
};

/// YAML::Load stops there and is silent; YAML::LoadAll of yaml-cpp 0.7 never ends on a stray comma.
bool GoesOnAfterFirstDocument(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Listener listener;
  parser.HandleNextDocument(listener);
  return static_cast<bool>(parser);
}

}  // namespace

std::string Printable(const std::string& raw) {
  constexpr std::size_t kLongestBytes = 60;
  std::string text;
  for (const char c : raw) {
    // A continuation byte of UTF-8 belongs to the character before it.
    const bool starts = (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    if (text.size() >= kLongestBytes && starts) return text + "...";
    text += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  }
  return text;
}

std::string Show(const YAML::Node& node) {
  std::string text;
  if (node.IsScalar()) {
    text = "'" + Printable(node.Scalar()) + "'";
  } else if (node.IsSequence()) {
    text = "a list of " + std::to_string(node.size());
  } else if (node.IsMap()) {
    text = "a map";
  } else {
    text = "nothing";
  }
  return text;
}

Result<YAML::Node> ParseYamlMap(const std::string& text, const std::string& name) {
  const auto refuse = [&name](const std::string& detail) {
    return Error{ErrorCode::kMalformed, name, detail};
  };
  if (text.size() > kLargestYamlBytes) return refuse("is larger than 1 MiB; a settings file has some KB");
  if (text.find('\0') != std::string::npos)
    return refuse("is not YAML: it holds zero bytes, as binary files do");
  try {
    const YAML::Node root = YAML::Load(text);
    if (GoesOnAfterFirstDocument(text)) {
      return refuse(
          "goes on after its first YAML document (---, or a stray bracket or comma); one is allowed");
    }
    if (!root.IsMap()) return refuse("must be a map of keys, is " + Show(root));
    return root;
  } catch (const YAML::Exception& e) {
    return Error{ErrorCode::kMalformed, name + ":" + std::to_string(e.mark.line + 1),
                 "is not YAML: " + Printable(e.msg)};
  }
}

}  // namespace adit::base
