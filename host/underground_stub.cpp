#include "host/underground_cases.h"
namespace adit::host {
SuiteReport MeasureFog(const CaseOrder&) { return {}; }
SuiteReport MeasureDrive(const CaseOrder&) { return {}; }
SuiteReport MeasureVibration(const CaseOrder&) { return {}; }
SuiteReport MeasureEllipsoid(const CaseOrder&) { return {}; }
SuiteReport MeasureStatic(const CaseOrder&) { return {}; }
SuiteReport MeasureFifteen(const CaseOrder&) { return {}; }
}  // namespace adit::host
