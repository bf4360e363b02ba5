// The GenICam description of a simulated camera (GenICam Standard 2.1, SFNC 2).
#include <sstream>
#include <vector>

#include "drivers/sim/gige_registers.h"

namespace adit::sim {
namespace {

struct Entry {
  const char* name;
  std::uint32_t value;
};

/// Writes nodes; every register is 4 bytes unless said.
class XmlWriter {
 public:
  void Register(const char* kind, const std::string& name, std::uint32_t address, const char* access,
                int bytes = 4) {
    text_ << "<" << kind << " Name=\"" << name << "\"><Address>0x" << std::hex << address << std::dec
          << "</Address><Length>" << bytes << "</Length><AccessMode>" << access
          << "</AccessMode><pPort>Device</pPort><Cachable>NoCache</Cachable>";
    if (std::string(kind) == "IntReg") text_ << "<Sign>Unsigned</Sign>";
    if (std::string(kind) != "StringReg") text_ << "<Endianess>BigEndian</Endianess>";
    text_ << "</" << kind << ">\n";
  }
  void Integer(const std::string& name, std::uint32_t address, const char* access, long max) {
    text_ << "<Integer Name=\"" << name << "\"><pValue>" << name << "Reg</pValue><Min>0</Min><Max>" << max
          << "</Max></Integer>\n";
    Register("IntReg", name + "Reg", address, access);
  }
  void Float(const std::string& name, std::uint32_t address, const char* unit, double max) {
    text_ << "<Float Name=\"" << name << "\"><pValue>" << name << "Reg</pValue><Min>0</Min><Max>" << max
          << "</Max><Unit>" << unit << "</Unit></Float>\n";
    Register("FloatReg", name + "Reg", address, "RW", 8);
  }
  void Enumeration(const std::string& name, std::uint32_t address, const std::vector<Entry>& entries) {
    text_ << "<Enumeration Name=\"" << name << "\">";
    for (const Entry& entry : entries) {
      text_ << "<EnumEntry Name=\"" << entry.name << "\"><Value>" << entry.value << "</Value></EnumEntry>";
    }
    text_ << "<pValue>" << name << "Reg</pValue></Enumeration>\n";
    Register("IntReg", name + "Reg", address, "RW");
  }
  void Constant(const std::string& name, const Entry& entry) {
    text_ << "<Enumeration Name=\"" << name << "\"><EnumEntry Name=\"" << entry.name << "\"><Value>"
          << entry.value << "</Value></EnumEntry><Value>" << entry.value << "</Value></Enumeration>\n";
  }
  void Command(const std::string& name, const std::string& value_of, int value) {
    text_ << "<Command Name=\"" << name << "\"><pValue>" << value_of << "</pValue><CommandValue>" << value
          << "</CommandValue></Command>\n";
  }
  void Raw(const std::string& text) { text_ << text; }
  std::string Done() const { return text_.str(); }

 private:
  std::ostringstream text_;
};

void WriteImageFormat(const GigeIdentity& identity, XmlWriter& xml) {
  const std::string width = std::to_string(identity.width_px), height = std::to_string(identity.height_px);
  xml.Raw("<Integer Name=\"SensorWidth\"><Value>" + width +
          "</Value></Integer>\n<Integer Name=\"SensorHeight\"><Value>" + height +
          "</Value></Integer>\n<Integer Name=\"WidthMax\"><Value>" + width +
          "</Value></Integer>\n<Integer Name=\"HeightMax\"><Value>" + height + "</Value></Integer>\n");
  xml.Integer("Width", kRegWidth, "RW", identity.width_px);
  xml.Integer("Height", kRegHeight, "RW", identity.height_px);
  xml.Enumeration("PixelFormat", kRegPixelFormat,
                  {{"Mono8", kMono8}, {"Mono10", kMono10}, {"Mono12", kMono12}});
  xml.Integer("PayloadSize", kRegPayload, "RO", 1L << 31);
}

void WriteAcquisition(const GigeIdentity& identity, XmlWriter& xml) {
  xml.Constant("AcquisitionMode", {"Continuous", 0});
  xml.Register("IntReg", "AcquisitionReg", kRegAcquisition, "RW");
  xml.Command("AcquisitionStart", "AcquisitionReg", 1);
  xml.Command("AcquisitionStop", "AcquisitionReg", 0);
  xml.Constant("TriggerSelector", {"FrameStart", 0});
  xml.Enumeration("TriggerMode", kRegTriggerMode, {{"Off", 0}, {"On", 1}});
  xml.Enumeration("TriggerSource", kRegTriggerSource, {{"Line0", 0}, {"Line1", 1}});
  constexpr double kLongestUs = 1e6;
  switch (identity.exposure) {
    case ExposureName::kExposureTime:
      xml.Float("ExposureTime", kRegExposure, "us", kLongestUs);
      break;
    case ExposureName::kExposureTimeAbs:
      xml.Float("ExposureTimeAbs", kRegExposure, "us", kLongestUs);
      break;
    case ExposureName::kExposureTimeRaw:
      xml.Integer("ExposureTimeRaw", kRegExposureRaw, "RW", 1'000'000);
      break;
  }
  xml.Float("Gain", kRegGain, "dB", 48);
  xml.Raw(
      "<Boolean "
      "Name=\"PtpEnable\"><pValue>PtpEnableReg</pValue><OnValue>1</OnValue><OffValue>0</OffValue></"
      "Boolean>\n");
  xml.Register("IntReg", "PtpEnableReg", kRegPtpEnable, "RW");
  xml.Enumeration("PtpStatus", kRegPtpStatus, {{"Disabled", 0}, {"Slave", 9}});
}

}  // namespace

std::string GigeXml(const GigeIdentity& identity) {
  XmlWriter xml;
  xml.Raw(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<RegisterDescription ModelName=\"simulated\" "
      "VendorName=\"adit\" "
      "StandardNameSpace=\"GEV\" SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" "
      "SchemaSubMinorVersion=\"0\" "
      "MajorVersion=\"1\" MinorVersion=\"0\" SubMinorVersion=\"0\" ToolTip=\"simulated camera\" "
      "ProductGuid=\"0\" "
      "VersionGuid=\"0\" xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n<Category Name=\"Root\">");
  for (const char* feature :
       {"DeviceVendorName", "DeviceModelName", "SensorWidth", "SensorHeight", "Width", "Height",
        "PixelFormat", "PayloadSize", "AcquisitionMode", "AcquisitionStart", "AcquisitionStop",
        "TriggerSelector", "TriggerMode", "TriggerSource", "Gain", "PtpEnable", "PtpStatus"}) {
    xml.Raw(std::string("<pFeature>") + feature + "</pFeature>");
  }
  xml.Raw("</Category>\n");
  xml.Register("StringReg", "DeviceVendorName", 0x48, "RO", 32);
  xml.Register("StringReg", "DeviceModelName", 0x68, "RO", 32);
  xml.Register("StringReg", "DeviceID", 0xD8, "RO", 16);
  WriteImageFormat(identity, xml);
  WriteAcquisition(identity, xml);
  xml.Raw("<Port Name=\"Device\"/>\n</RegisterDescription>\n");
  return xml.Done();
}

}  // namespace adit::sim
