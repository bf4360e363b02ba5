adit_fuzz(modbus ROUNDS 20000 DEPENDS adit_modbus adit_publish)
