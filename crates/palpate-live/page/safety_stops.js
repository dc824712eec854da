// Why a lane has no force, as its banner says it.

/**
 * @param {{method: string, safety_stop: string | null, safety_stop_method?: string | null}} lane of the state
 * @param {number} number of the lane, from 1
 * @returns {string | null} null where nothing keeps the force away
 */
export function safetyStopInWords({ method, safety_stop = null, safety_stop_method: culprit = null } = {}, number) {
  if (safety_stop === null) {
    return null;
  }
  if (culprit === null) {
    // The device, the hand or the machine: no method is to blame.
    return `Rendering ${number}: no force, because ${safety_stop}.`;
  }
  if (culprit === method) {
    return `${method}: no force, because ${safety_stop}.`;
  }
  return `Rendering ${number}: no force, because of the previous method ${culprit}: ${safety_stop}. ${method} renders now; Rearm restores the force.`;
}
