adit_fuzz(settings ROUNDS 3000 DEPENDS adit_optics adit_identify adit_config)
